#include "analysis/laws/chi_square/chi_square_dependent_sum.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>

#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

constexpr double kSmallestPValue = 1e-300;

// Steps share few values of the dof: each is computed once.
using DofCounts = std::map<double, std::int64_t>;

DofCounts count_dofs(std::span<const double> dofs) {
  if (dofs.empty()) throw std::invalid_argument("dofs is empty: a sum needs at least one term");
  DofCounts counts;
  for (const double dof : dofs) {
    if (!(std::isfinite(dof) && dof > 0.0)) {
      throw std::invalid_argument(fmt::format("dof = {} must be a finite number > 0", dof));
    }
    ++counts[dof];
  }
  return counts;
}

template <typename TailMean>
double sum_over(const DofCounts& counts, TailMean tail_mean) {
  double sum = 0.0;
  for (const auto& [dof, count] : counts) sum += static_cast<double>(count) * tail_mean(dof);
  return sum;
}

double upper_shortfall(const DofCounts& counts, double probability) {
  return sum_over(counts, [&](double dof) { return chi_square_upper_tail_mean(probability, dof); });
}

double lower_shortfall(const DofCounts& counts, double probability) {
  return sum_over(counts, [&](double dof) { return chi_square_lower_tail_mean(probability, dof); });
}

// The p at which the shortfall meets the sum; `excess(log p)` falls from above 0 to below 0.
template <typename Excess>
double solve_p_value(Excess excess) {
  const double lowest = std::log(kSmallestPValue);
  if (excess(lowest) <= 0.0) return 0.0;
  std::uintmax_t iterations = 200;
  const boost::math::tools::eps_tolerance<double> tolerance(40);
  const auto bracket = boost::math::tools::toms748_solve(excess, lowest, 0.0, tolerance, iterations);
  return std::exp(bracket.second);
}

}  // namespace

ChiSquareBounds dependent_sum_bounds(std::span<const double> dofs, double confidence) {
  require_confidence(confidence);
  const DofCounts counts = count_dofs(dofs);
  const double tail = 0.5 * (1.0 - confidence);
  return {lower_shortfall(counts, tail), upper_shortfall(counts, tail)};
}

TailPValues dependent_sum_tails(double sum, std::span<const double> dofs) {
  const DofCounts counts = count_dofs(dofs);
  if (std::isnan(sum)) return {sum, sum};
  if (sum < 0.0) return {.lower = 0.0, .upper = 1.0};
  if (std::isinf(sum)) return {.lower = 1.0, .upper = 0.0};
  const double expected = sum_over(counts, [](double dof) { return dof; });
  TailPValues tails;
  if (sum > expected) {
    tails.upper = solve_p_value([&](double log_p) { return upper_shortfall(counts, std::exp(log_p)) - sum; });
  } else if (sum < expected) {
    tails.lower = solve_p_value([&](double log_p) { return sum - lower_shortfall(counts, std::exp(log_p)); });
  }
  return tails;
}

double dependent_sum_p_value(double sum, std::span<const double> dofs) {
  const TailPValues tails = dependent_sum_tails(sum, dofs);
  if (std::isnan(tails.lower)) return tails.lower;
  return std::min(1.0, 2.0 * std::min(tails.lower, tails.upper));
}

}  // namespace credence::internal
