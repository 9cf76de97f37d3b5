#include "analysis/laws/equivalence.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kFewestRunsForPower = 20.0;
constexpr double kMostRunsForEquivalence = 1e12;

}  // namespace

double equivalence_p_value(const SkewedMoments& run_averages, double delta, double least_dof) {
  require_positive("delta", delta);
  const double too_large = run_mean_p_values(run_averages, 1.0 + delta, least_dof).pessimistic;
  const double too_small = run_mean_p_values(run_averages, 1.0 / (1.0 + delta), least_dof).optimistic;
  return std::isnan(too_large) ? kNaN : std::max(too_large, too_small);
}

double proved_within(const SkewedMoments& run_averages, double confidence, double least_dof) {
  if (!(confidence > 0.5 && confidence < 1.0)) {
    throw std::invalid_argument(fmt::format("confidence = {} must lie in (0.5, 1)", confidence));
  }
  const MeanInterval interval = run_mean_interval(run_averages, 2.0 * confidence - 1.0, least_dof);
  if (!interval.reason.empty()) return kNaN;
  if (interval.lower <= 0.0) return std::numeric_limits<double>::infinity();
  return std::max(interval.upper, 1.0 / interval.lower) - 1.0;
}

double equivalence_power(double runs, double relative_variance, double delta, double alpha, double factor) {
  if (!(runs >= kFewestRunsForPower)) {
    throw std::invalid_argument(fmt::format("runs = {} must be at least {}", runs, kFewestRunsForPower));
  }
  require_positive("relative_variance", relative_variance);
  require_positive("delta", delta);
  require_fraction("2 alpha", 2.0 * alpha);
  require_positive("factor", factor);
  // (x̄/factor)^{1/3} ~ N(1 − c, c), and it is proved between the means that Student's quantile leaves.
  const double c = relative_variance / (9.0 * runs);
  const double t = student_quantile_two_sided(1.0 - 2.0 * alpha, runs - 1.0);
  const double root = std::cbrt(1.0 + delta);
  const double upper = root * (1.0 - c - t * std::sqrt(c));
  const double lower = (1.0 - c + t * std::sqrt(c)) / root;
  if (upper <= lower) return 0.0;
  const boost::math::normal_distribution<double> law(1.0 - c, std::sqrt(c));
  const double scale = std::cbrt(factor);
  return cdf(law, upper / scale) - cdf(law, lower / scale);
}

std::int64_t runs_for_equivalence(double relative_variance, double delta, double alpha, double power) {
  require_fraction("power", power);
  const auto enough = [&](double runs) {
    return equivalence_power(runs, relative_variance, delta, alpha) >= power;
  };
  double most = kFewestRunsForPower;
  while (!enough(most)) {
    most *= 2.0;
    if (most > kMostRunsForEquivalence)
      throw std::invalid_argument(fmt::format("delta = {} needs too many runs", delta));
  }
  double least = std::max(kFewestRunsForPower, std::floor(0.5 * most));
  if (enough(least)) return static_cast<std::int64_t>(least);
  while (most - least > 1.0) {
    const double middle = std::floor(0.5 * (least + most));
    (enough(middle) ? most : least) = middle;
  }
  return static_cast<std::int64_t>(most);
}

}  // namespace credence::internal
