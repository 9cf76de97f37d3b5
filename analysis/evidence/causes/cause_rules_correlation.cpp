#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"

namespace credence::internal {

Causes find_sequential_sensors(const Findings& findings) {
  // A wrong gain correlates sensors that were taken one after the other too, but no more than it does each
  // with itself a whole step later, apart from what fades in that. The correlation of a pair is that of its
  // best direction, in which all components of a sensor may have joined.
  constexpr double kMoreThanInTime = 1.5;
  const auto components =
      findings.whiteness ? static_cast<double>(std::max(findings.whiteness->dim, Index{1})) : 1.0;
  const double in_time = components * std::abs(lag_1_outside(findings));
  for (const Findings::SensorPair& pair : findings.sensor_pairs) {
    const BlockCorrelationTest& test = pair.correlation;
    if (!(test.p_value <= cause_level(findings)) || test.largest < kMoreThanInTime * in_time) continue;
    return {{Cause::sequential_sensors,
             fmt::format("those of {} and {} at the same step are correlated, {:.2g} at most (p = "
                         "{:.2g}): their NIS must not be added, and a filter that updates with both "
                         "from the same prior counts that prior twice",
                         pair.first, pair.second, test.largest, test.p_value)}};
  }
  return {};
}

Causes find_dropped_cross_covariance(const Findings& findings) {
  constexpr double kLeast = 0.05;  // of many runs a correlation is significant that is of no size
  if (!findings.error_correlation || !(findings.error_correlation->p_value <= cause_level(findings)))
    return {};
  const ErrorCorrelationTest& test = *findings.error_correlation;
  if (test.largest < kLeast) return {};
  return {{Cause::cross_covariance,
           fmt::format("errors of states that P claims to be uncorrelated are correlated, by {:.2g} at "
                       "most (p = {:.2g})",
                       test.largest, test.p_value)}};
}

Causes find_joint_inconsistency(const Findings& findings) {
  if (!findings.block || !findings.block->joint_only) return {};
  return {{Cause::cross_covariance, fmt::format("mean NEES {:.3g} of {:.3g}, and no block is inconsistent",
                                                findings.nees.mean, findings.nees.expected)}};
}

}  // namespace credence::internal
