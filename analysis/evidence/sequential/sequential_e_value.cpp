#include "analysis/evidence/sequential/sequential_e_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "analysis/laws/require.h"
#include "analysis/laws/scores/log_mean_exp.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::array<double, 5> kPriors{1.0, 10.0, 100.0, 1000.0, 10000.0};

// The mixture for one dof; steps mostly share it, so its gamma functions are kept.
class Mixture {
 public:
  double log_e(double sum, double dof) {
    if (dof == 0.0) return 0.0;
    if (std::isnan(sum) || sum < 0.0) return kNaN;
    if (std::isinf(sum)) return kInfinity;
    prepare(dof);
    std::array<double, kPriors.size()> logs;
    for (std::size_t i = 0; i < kPriors.size(); ++i) {
      const double a = kPriors[i];
      logs[i] = constant_[i] - (a + 0.5 * dof) * std::log(a + 0.5 * sum) + 0.5 * sum;
    }
    return log_mean_exp(logs);
  }

 private:
  void prepare(double dof) {
    if (dof == dof_) return;
    dof_ = dof;
    for (std::size_t i = 0; i < kPriors.size(); ++i) {
      const double a = kPriors[i];
      constant_[i] = a * std::log(a) + boost::math::lgamma(a + 0.5 * dof) - boost::math::lgamma(a);
    }
  }

  double dof_ = 0.0;
  std::array<double, kPriors.size()> constant_{};
};

void require_sizes(std::span<const Moments> per_step, std::span<const double> dofs) {
  if (per_step.size() != dofs.size()) {
    throw std::invalid_argument(
        fmt::format("{} steps of moments but {} steps of dof", per_step.size(), dofs.size()));
  }
}

// The sums at every step and over all of them, which is all that an e-value needs.
struct Sums {
  std::vector<double> sum, dof;
  std::vector<double> shares;  ///< of each step: the least of its own, where that is significant, and of all
  double total_sum = 0.0, total_dof = 0.0;
  double share = 1.0;  ///< share_of_law
};

// The share of one step where its variance is beyond three standard errors of that of χ², else 1: what one
// run adds to a sum is no evidence beyond it.
double significant_share(const Moments& step, double total_dof) {
  constexpr double kStandardErrors = 3.0;
  if (step.count < 2 || !(total_dof > 0.0)) return 1.0;
  const double n = static_cast<double>(step.count), dof = total_dof / n;
  const double standard_error = std::sqrt((2.0 + 12.0 / dof) / n);  // relative, of kurtosis 3 + 12/d
  const double of_law = 2.0 * step.mean * step.mean / dof, found = step.variance();
  return std::isfinite(found) && found > of_law * (1.0 + kStandardErrors * standard_error) ? of_law / found
                                                                                           : 1.0;
}

Sums collect(std::span<const Moments> per_step, std::span<const double> dofs) {
  require_sizes(per_step, dofs);
  Sums sums;
  sums.share = share_of_law(per_step, dofs);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    const bool data = per_step[k].count > 0 && dofs[k] > 0.0;
    sums.sum.push_back(data ? static_cast<double>(per_step[k].count) * per_step[k].mean : 0.0);
    sums.dof.push_back(data ? dofs[k] : 0.0);
    sums.shares.push_back(std::min(sums.share, significant_share(per_step[k], dofs[k])));
    sums.total_sum += sums.sum.back();
    sums.total_dof += sums.dof.back();
  }
  return sums;
}

// Of the steps, with all sums divided by `scale`: the evidence against the covariance scale · P, that of each
// step discounted by its share, or with none by χ² alone.
double log_e(const Sums& sums, double scale, const std::vector<double>& shares = {}) {
  if (sums.sum.empty()) return 0.0;
  Mixture mixture;
  std::vector<double> logs;
  logs.reserve(sums.sum.size());
  for (std::size_t k = 0; k < sums.sum.size(); ++k) {
    const double by_law = mixture.log_e(sums.sum[k] / scale, sums.dof[k]);
    logs.push_back(shares.empty() ? by_law : discounted(by_law, shares[k]));
    if (std::isnan(logs.back())) return kNaN;
  }
  return log_mean_exp(logs);
}

}  // namespace

double share_of_law(std::span<const Moments> per_step, std::span<const double> total_dof_per_step) {
  require_sizes(per_step, total_dof_per_step);
  double of_law = 0.0, found = 0.0;
  for (std::size_t k = 0; k < per_step.size(); ++k) {
    const Moments& step = per_step[k];
    if (step.count < 2 || !(total_dof_per_step[k] > 0.0)) continue;
    const double dof = total_dof_per_step[k] / static_cast<double>(step.count);
    of_law += 2.0 * step.mean * step.mean / dof;
    found += step.variance();
  }
  return found > of_law && std::isfinite(found) ? of_law / found : 1.0;
}

double log_e_value(double sum, double dof) {
  if (!(std::isfinite(dof) && dof >= 0.0)) {
    throw std::invalid_argument(fmt::format("dof = {} must be a finite number >= 0", dof));
  }
  return Mixture().log_e(sum, dof);
}

double log_e_nees(std::span<const Moments> per_step, std::span<const double> total_dof_per_step) {
  const Sums sums = collect(per_step, total_dof_per_step);
  return log_e(sums, 1.0, sums.shares);
}

double log_e_nis(std::span<const Moments> per_step, std::span<const double> total_dof_per_step) {
  const Sums sums = collect(per_step, total_dof_per_step);
  const double steps = log_e(sums, 1.0, sums.shares);
  if (sums.sum.empty() || std::isnan(steps)) return steps;
  const double all = discounted(Mixture().log_e(sums.total_sum, sums.total_dof), sums.share);
  return log_mean_exp(std::array{steps, all});
}

ChiSquareBounds scale_confidence_sequence(std::span<const Moments> per_step,
                                          std::span<const double> total_dof_per_step, double confidence) {
  require_confidence(confidence);
  const Sums sums = collect(per_step, total_dof_per_step);
  if (sums.total_dof == 0.0) return {0.0, kInfinity};
  if (!std::isfinite(sums.total_sum) || std::isnan(log_e(sums, 1.0))) return {kNaN, kNaN};
  if (sums.total_sum == 0.0) return {0.0, 0.0};

  // ln E is convex in 1/scale, so the factors not refuted are an interval around the least refuted one; its
  // end at 1/scale → 0 may not exist, as S = 0 has a bounded likelihood ratio.
  const double limit = -std::log(1.0 - confidence);
  const auto excess = [&](double log_scale) {
    return discounted(log_e(sums, std::exp(log_scale)), sums.share) - limit;
  };
  const double centre = std::log(sums.total_sum / sums.total_dof);
  double best = boost::math::tools::brent_find_minima(excess, centre - 5.0, centre + 5.0, 20).first;
  if (excess(best) > 0.0) {  // a step far from the others: each is fitted best by its own factor
    double least = centre - 5.0, largest = centre + 5.0;
    for (std::size_t k = 0; k < per_step.size(); ++k) {
      const double sum = static_cast<double>(per_step[k].count) * per_step[k].mean;
      if (!(sum > 0.0 && total_dof_per_step[k] > 0.0)) continue;
      least = std::min(least, std::log(sum / total_dof_per_step[k]));
      largest = std::max(largest, std::log(sum / total_dof_per_step[k]));
    }
    best = boost::math::tools::brent_find_minima(excess, least, largest, 40).first;
  }
  if (excess(best) > 0.0) return {kNaN, kNaN};
  const auto solve = [&](double inside, double outside) {
    std::uintmax_t iterations = 100;
    const boost::math::tools::eps_tolerance<double> tolerance(36);
    const auto [a, b] = inside < outside
                            ? boost::math::tools::bisect(excess, inside, outside, tolerance, iterations)
                            : boost::math::tools::bisect(excess, outside, inside, tolerance, iterations);
    return std::exp(0.5 * (a + b));
  };
  constexpr double kFar = 60.0;
  ChiSquareBounds bounds{0.0, kInfinity};
  if (excess(best - kFar) > 0.0) bounds.lower = solve(best, best - kFar);
  if (excess(best + kFar) > 0.0) bounds.upper = solve(best, best + kFar);
  return bounds;
}

}  // namespace credence::internal
