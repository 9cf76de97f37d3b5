#pragma once

#include "core/types.h"

namespace credence {

/// P ← T P Tᵀ + K R Kᵀ with T = I − K H (Joseph's form) for symmetric dense P; R is one block of the block
/// diagonal covariance of the measurement.
///
/// The part of T that H touches is formed before it meets P: where a measurement is far more exact than the
/// prior, T is small there and so is the rounding, which P − K H P would leave at the prior's scale. Costs
/// O(n² dim ν); allocates.
void joseph_update(Matrix& P, const MatrixRef& H, const Matrix& K, const Matrix& R);

}  // namespace credence
