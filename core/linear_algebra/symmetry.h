#pragma once

#include "core/types.h"

namespace credence::internal {

/// How far the two triangles of a covariance that someone hands over may differ, in units of the standard
/// deviations: float has seven digits, and rounding adds up.
inline constexpr double kMostAsymmetry = 1e-5;

/// Whether the two triangles of a covariance agree within `tolerance`, in units of the standard deviations.
/// What is not finite does not.
bool is_symmetric(const Matrix& P, double tolerance);

/// The same within kMostAsymmetry; both triangles are then the lower one.
bool make_symmetric(Matrix& P);

}  // namespace credence::internal
