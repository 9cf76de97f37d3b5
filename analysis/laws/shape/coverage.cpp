#include "analysis/laws/shape/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <map>
#include <stdexcept>
#include <tuple>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

void require_count(const CoverageCount& count) {
  if (count.inside < 0 || count.total < count.inside) {
    throw std::invalid_argument(fmt::format("{} of {} is no proportion", count.inside, count.total));
  }
}

}  // namespace

double expected_coverage(double k_sigma, double dof) {
  if (!(k_sigma >= 0.0)) throw std::invalid_argument(fmt::format("k = {} must be >= 0", k_sigma));
  return chi_square_cdf(k_sigma * k_sigma, dof);
}

ProportionInterval clopper_pearson(const CoverageCount& count, double confidence) {
  require_count(count);
  require_confidence(confidence);
  if (count.total == 0) return {.value = kNaN};
  const double inside = static_cast<double>(count.inside);
  const double outside = static_cast<double>(count.total - count.inside);
  const double tail = 0.5 * (1.0 - confidence);
  ProportionInterval interval{.value = inside / (inside + outside)};
  if (count.inside > 0) {
    interval.lower = quantile(boost::math::beta_distribution<>(inside, outside + 1.0), tail);
  }
  if (count.inside < count.total) {
    interval.upper = quantile(complement(boost::math::beta_distribution<>(inside + 1.0, outside), tail));
  }
  return interval;
}

double binomial_upper_tail(std::int64_t count, std::int64_t trials, double probability) {
  if (count <= 0) return 1.0;
  const boost::math::binomial law(static_cast<double>(trials), probability);
  return cdf(complement(law, static_cast<double>(count - 1)));
}

double binomial_p_value(const CoverageCount& count, double probability) {
  require_count(count);
  require_probability(probability);
  if (count.total == 0) return 1.0;
  const boost::math::binomial law(static_cast<double>(count.total), probability);
  const double inside = static_cast<double>(count.inside);
  const double at_most = cdf(law, inside);
  const double at_least = count.inside == 0 ? 1.0 : cdf(complement(law, inside - 1.0));
  return std::min(1.0, 2.0 * std::min(at_most, at_least));
}

CoverageVerdict judge_coverage(std::span<const CoverageCount> per_step, std::span<const double> expected,
                               double confidence) {
  require_confidence(confidence);
  if (per_step.size() != expected.size()) {
    throw std::invalid_argument(
        fmt::format("{} steps of counts but {} of expected coverage", per_step.size(), expected.size()));
  }
  CoverageVerdict result;
  double smallest = 2.0;
  double expected_inside = 0.0;
  // Steps share few counts, and one costs two incomplete beta functions and two inverse ones.
  std::map<std::tuple<std::int64_t, std::int64_t, double>, CoverageStep> judged;
  const auto judged_step = [&](const CoverageCount& count, double share) -> const CoverageStep& {
    const auto [entry, is_new] = judged.try_emplace({count.inside, count.total, share});
    if (is_new) {
      entry->second = {.count = count,
                       .interval = clopper_pearson(count, confidence),
                       .expected = share,
                       .p_value = binomial_p_value(count, share)};
    }
    return entry->second;
  };
  result.steps.reserve(per_step.size());
  for (std::size_t k = 0; k < per_step.size(); ++k) {
    const CoverageStep& step = result.steps.emplace_back(judged_step(per_step[k], expected[k]));
    if (step.count.total == 0) continue;
    ++result.tests;
    result.pooled.merge(step.count);
    expected_inside += step.expected * static_cast<double>(step.count.total);
    if (step.p_value < smallest) {
      smallest = step.p_value;
      result.worst_step = static_cast<std::int64_t>(k);
    }
  }
  if (result.tests == 0) return result;
  result.expected = expected_inside / static_cast<double>(result.pooled.total);
  result.p_value = std::min(1.0, smallest * static_cast<double>(result.tests));
  if (result.p_value > 1.0 - confidence) {
    result.verdict = Verdict::consistent;
  } else {
    const CoverageStep& worst = result.steps[static_cast<std::size_t>(result.worst_step)];
    result.verdict = worst.interval.value < worst.expected ? Verdict::optimistic : Verdict::pessimistic;
  }
  return result;
}

}  // namespace credence::internal
