#pragma once

#include "core/types.h"

namespace credence::internal {

/// Whether the two triangles of a covariance agree within `tolerance`, in units of the standard deviations.
/// What is not finite does not.
bool is_symmetric(const Matrix& P, double tolerance);

/// The same; both triangles are then the lower one.
bool make_symmetric(Matrix& P, double tolerance);

}  // namespace credence::internal
