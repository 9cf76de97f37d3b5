#include "analysis/laws/chi_square/chi_square_cumulants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

// X = mean + scale (χ²(dof) − dof); a negative scale mirrors the law for a negative third cumulant.
struct ShiftedChiSquare {
  double dof, scale;
};

ShiftedChiSquare match(const Cumulants& cumulants) {
  const auto& [mean, variance, third] = cumulants;
  if (!(std::isfinite(mean) && std::isfinite(variance) && variance > 0.0 && std::isfinite(third))) {
    throw std::invalid_argument(
        fmt::format("cumulants {}, {}, {} must be finite with a positive variance", mean, variance, third));
  }
  // Beyond 1e12 dof the law is normal to all digits: a vanishing skewness needs no special case.
  constexpr double kNormalDof = 1e12;
  const double skewness = third / (variance * std::sqrt(variance));
  const double dof = std::min(kNormalDof, 8.0 / (skewness * skewness));
  return {dof, std::copysign(std::sqrt(variance / (2.0 * dof)), third)};
}

}  // namespace

double two_sided_p_value(double x, const Cumulants& cumulants) {
  const ShiftedChiSquare law = match(cumulants);
  if (std::isinf(x)) return 0.0;
  return two_sided_p_value(law.dof + (x - cumulants.mean) / law.scale, law.dof);
}

double upper_p_value(double x, const Cumulants& cumulants) {
  const ShiftedChiSquare law = match(cumulants);
  if (std::isinf(x)) return x > 0.0 ? 0.0 : 1.0;
  const double chi = law.dof + (x - cumulants.mean) / law.scale;
  return law.scale > 0.0 ? chi_square_survival(chi, law.dof) : chi_square_cdf(chi, law.dof);
}

ChiSquareBounds sum_bounds(const Cumulants& cumulants, double confidence) {
  const ShiftedChiSquare law = match(cumulants);
  const ChiSquareBounds chi = mean_bounds(law.dof, 1.0, confidence);
  const double at_lower = cumulants.mean + law.scale * (chi.lower - law.dof);
  const double at_upper = cumulants.mean + law.scale * (chi.upper - law.dof);
  return law.scale > 0.0 ? ChiSquareBounds{at_lower, at_upper} : ChiSquareBounds{at_upper, at_lower};
}

}  // namespace credence::internal
