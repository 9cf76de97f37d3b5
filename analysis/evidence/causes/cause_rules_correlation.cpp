#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// Of two innovations, each over its σ, that S takes for uncorrelated: of their sum and difference.
double correlation_of_pair(const Findings::WrongPair& pair) {
  return std::abs(pair.sum.mean - pair.difference.mean) / (pair.sum.mean + pair.difference.mean);
}

}  // namespace

Causes find_sequential_sensors(const Findings& findings) {
  // A gain that is too small by two noises, wrong in opposite directions; the same prior taken twice corrects
  // too much.
  if (innovation_shape(findings).gain > 0) return {};
  for (const Findings::SensorPair& pair : findings.sensor_pairs) {
    const BlockCorrelationTest& test = pair.correlation;
    if (!(std::max(test.p_value, pair.opposed_p_value) <= cause_level(findings))) continue;
    return {{Cause::sequential_sensors,
             fmt::format(
                 "those of {} and {} at the same step are correlated, {} at most ({}), and as no "
                 "Q, R or P0 makes them that is wrong in one direction ({}): their NIS must not be "
                 "added; a filter that updates with both from the same prior, or takes for independent what "
                 "disturbs both, corrects too much",
                 pair.first, pair.second, number_text(test.largest, 2), p_value_statement(test.p_value),
                 p_value_statement(pair.opposed_p_value))}};
  }
  return {};
}

Causes find_dropped_cross_covariance(const Findings& findings) {
  constexpr double kLeast = 0.05;  // of many runs a correlation is significant that is of no size
  constexpr double kNearly = 0.75;
  if (!findings.error_correlation || !(findings.error_correlation->p_value <= cause_level(findings)))
    return {};
  const ErrorCorrelationTest& test = *findings.error_correlation;
  if (test.largest < kLeast) return {};
  Causes found = {{Cause::cross_covariance,
                   fmt::format("errors of states that P claims to be uncorrelated are correlated, by {} at "
                               "most ({})",
                               number_text(test.largest, 2), p_value_statement(test.p_value))}};
  Causes pair = find_wrong_pair(findings);
  const bool of_R = !pair.empty() && correlation_of_pair(*findings.wrong_pair) > kNearly * test.largest;
  found.insert(of_R ? found.begin() : found.end(), pair.begin(), pair.end());
  return found;
}

Causes find_joint_inconsistency(const Findings& findings) {
  if (!findings.block || !findings.block->joint_only) return {};
  return {{Cause::cross_covariance,
           fmt::format("mean NEES {} of {}, and no block is inconsistent", number_text(findings.nees.mean, 3),
                       number_text(findings.nees.expected, 3))}};
}

}  // namespace credence::internal
