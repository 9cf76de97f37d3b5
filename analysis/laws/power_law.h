#pragma once

#include <span>

namespace credence::internal {

/// y = c x^exponent, fitted by least squares of log y on log x.
struct PowerLaw {
  double exponent = 0.0;
  /// 95 % interval of the exponent, by Student t on the scatter about the line; NaN for two points.
  double lower = 0.0, upper = 0.0;
};

/// Fits a power law.
///
/// The interval says how well a straight line fits these points, not what another machine would give. Throws
/// std::invalid_argument for fewer than two points or two different x, or values that are not positive.
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y);

}  // namespace credence::internal
