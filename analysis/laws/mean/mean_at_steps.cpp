#include "analysis/laws/mean/mean_at_steps.h"

#include <algorithm>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/zero_mean.h"

namespace credence::internal {

bool MeanAtSteps::shared(double level) const {
  constexpr double kLike = 3.0, kMostOfOne = 0.5;
  const double missing = 1.0 - spread;
  return std::max(p_value, spread_p_value) <= level && square < kLike * missing && missing < kLike * square &&
         of_one < kMostOfOne;
}

bool MeanAtSteps::passes(double level) const {
  constexpr double kAllGone = 0.1;
  return p_value <= level && (later_p_value > level || later_square < kAllGone * early_square);
}

MeanAtSteps test_mean_at_steps(const std::map<std::int64_t, VectorMoments>& whitened) {
  constexpr std::int64_t kFewest = 10;
  MeanAtSteps result;
  double of_mean = 0.0, excess = 0.0, steps = 0.0, of_sum = 0.0, spread = 0.0, dim = 0.0, squares = 0.0;
  double early = 0.0, early_dim = 0.0, later = 0.0, later_dim = 0.0, later_steps = 0.0, later_p_value = 1.0;
  const std::int64_t first_fifth = whitened.empty() ? 0 : whitened.rbegin()->first / 5;
  Vector sum;
  for (const auto& [step, errors] : whitened) {
    if (errors.count < kFewest && errors.count <= errors.mean.size()) continue;
    const ZeroMeanTest test = test_zero_mean(errors);
    if (!test.reason.empty()) continue;
    const auto runs = static_cast<double>(errors.count), n = static_cast<double>(errors.mean.size());
    const double square = errors.mean.squaredNorm(), scatter = errors.scatter.trace();
    const double without_error = square - scatter / (runs * (runs - 1.0));
    of_mean += without_error;
    if (step > first_fifth) {
      later += without_error;
      later_dim += n;
      later_steps += 1.0;
      later_p_value = std::min(later_p_value, test.p_value);
    } else {
      early += without_error;
      early_dim += n;
    }
    excess += square + scatter / runs - n;
    result.p_value = std::min(result.p_value, test.p_value);
    result.spread_p_value = std::min(result.spread_p_value, chi_square_cdf(scatter, (runs - 1.0) * n));
    spread += scatter / (runs - 1.0);
    dim += n;
    steps += 1.0;
    if (sum.size() == 0) sum = Vector::Zero(errors.mean.size());
    if (sum.size() != errors.mean.size()) continue;
    sum += errors.mean;
    squares += square;
    of_sum += 1.0;
  }
  if (steps == 0.0) return {};
  result.explained = excess > 0.0 ? std::max(0.0, of_mean) / excess : 0.0;
  result.p_value = std::min(1.0, steps * result.p_value);
  result.spread_p_value = std::min(1.0, steps * result.spread_p_value);
  result.square = std::max(0.0, of_mean) / dim;
  if (early_dim > 0.0) result.early_square = std::max(0.0, early) / early_dim;
  if (later_dim > 0.0) {
    result.later_square = std::max(0.0, later) / later_dim;
    result.later_p_value = std::min(1.0, later_steps * later_p_value);
  }
  result.of_one = squares > 0.0 ? sum.squaredNorm() / (of_sum * squares) : 1.0;
  result.spread = spread / dim;
  return result;
}

}  // namespace credence::internal
