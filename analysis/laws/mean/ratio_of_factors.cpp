#include "analysis/laws/mean/ratio_of_factors.h"

#include <cmath>
#include <numbers>

#include "analysis/laws/normal_quantile.h"

namespace credence::internal {

bool FactorInterval::is_known() const { return lower > 0.0 && upper < HUGE_VAL && factor > 0.0; }

RatioOfFactors ratio_of_factors(const FactorInterval& second, const FactorInterval& first,
                                double confidence) {
  const auto below = [](const FactorInterval& f) { return std::log(f.factor / f.lower) / f.quantile; };
  const auto above = [](const FactorInterval& f) { return std::log(f.upper / f.factor) / f.quantile; };
  const double step = std::log(second.factor / first.factor);
  const double down = std::hypot(below(second), above(first)), up = std::hypot(above(second), below(first));
  const double z = normal_quantile_two_sided(confidence), score = step / (step > 0.0 ? down : up);
  return {
      .ratio = {.mean = std::exp(step), .lower = std::exp(step - z * down), .upper = std::exp(step + z * up)},
      .p_value = std::isnan(score) ? 1.0 : std::erfc(std::abs(score) / std::numbers::sqrt2)};
}

double p_value_of_middle(const FactorInterval& second, const FactorInterval& first) {
  constexpr double kAny = 0.95;  // the p-value does not depend on it
  const FactorInterval inverse = {1.0 / first.factor, 1.0 / first.upper, 1.0 / first.lower, first.quantile};
  return ratio_of_factors(second, inverse, kAny).p_value;
}

}  // namespace credence::internal
