#include "analysis/laws/wishart_roots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/chi_square.h"
#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

// TW₁ ≈ kScale/2 χ²(2 kShape) + kShift [Chiani 2014].
constexpr double kShape = 46.446;
constexpr double kScale = 0.186054;
constexpr double kShift = -9.84801;

double tracy_widom_survival(double s) {
  return chi_square_survival(2.0 * (s - kShift) / kScale, 2.0 * kShape);
}

double tracy_widom_upper_quantile(double probability) {
  return 0.5 * kScale * chi_square_upper_quantile(probability, 2.0 * kShape) + kShift;
}

struct CentreAndScale {
  double centre, scale;
};

void require_sample(double runs, Index n) {
  if (!(n >= 1 && std::isfinite(runs) && runs > static_cast<double>(n))) {
    throw std::invalid_argument(fmt::format("{} runs must be more than the dimension, {} >= 1", runs, n));
  }
}

CentreAndScale of_largest(double runs, Index n) {
  const double a = std::sqrt(runs - 0.5);
  const double b = std::sqrt(static_cast<double>(n) - 0.5);
  return {(a + b) * (a + b), (a + b) * std::cbrt(1.0 / a + 1.0 / b)};
}

// Of the logarithm.
CentreAndScale of_smallest(double runs, Index n) {
  const double a = std::sqrt(runs - 0.5);
  const double b = std::sqrt(static_cast<double>(n) - 0.5);
  const double tau = std::cbrt(1.0 / b - 1.0 / a) / (a - b);
  return {2.0 * std::log(a - b) + tau * tau / 8.0, tau};
}

}  // namespace

double largest_root_p_value(double x, double runs, Index n) {
  require_sample(runs, n);
  if (std::isnan(x)) return x;
  if (n == 1) return chi_square_survival(runs * x, runs);
  const auto [centre, scale] = of_largest(runs, n);
  return tracy_widom_survival((runs * x - centre) / scale);
}

double smallest_root_p_value(double x, double runs, Index n) {
  require_sample(runs, n);
  if (std::isnan(x)) return x;
  if (x <= 0.0) return 0.0;
  if (n == 1) return chi_square_cdf(runs * x, runs);
  const auto [centre, scale] = of_smallest(runs, n);
  return tracy_widom_survival((centre - std::log(runs * x)) / scale);
}

double largest_root_quantile(double probability, double runs, Index n) {
  require_sample(runs, n);
  require_fraction("probability", probability);
  if (n == 1) return chi_square_upper_quantile(probability, runs) / runs;
  const auto [centre, scale] = of_largest(runs, n);
  return (centre + scale * tracy_widom_upper_quantile(probability)) / runs;
}

double smallest_root_quantile(double probability, double runs, Index n) {
  require_sample(runs, n);
  require_fraction("probability", probability);
  if (n == 1) return chi_square_quantile(probability, runs) / runs;
  const auto [centre, scale] = of_smallest(runs, n);
  return std::exp(centre - scale * tracy_widom_upper_quantile(probability)) / runs;
}

}  // namespace credence::internal
