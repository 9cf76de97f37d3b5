#pragma once

namespace credence::internal {

/// How far the two triangles of a covariance that someone hands over may differ, in units of the standard
/// deviations: float has seven digits, and rounding adds up.
inline constexpr double kMostAsymmetry = 1e-5;

}  // namespace credence::internal
