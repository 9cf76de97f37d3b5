#pragma once

#include <vector>

#include "core/linear_algebra/matrix_buffer.h"
#include "core/types.h"

namespace credence::internal {

/// P ← T P Tᵀ + K R Kᵀ with T = I − K H (Joseph's form) for symmetric dense P; R is one block of the block
/// diagonal covariance of the measurement.
///
/// The part of T that H touches is formed before it meets P: where a measurement is far more exact than the
/// prior, T is small there and so is the rounding, which P − K H P would leave at the prior's scale. Costs
/// O(n² dim ν). Keeps its memory, so that an update of no larger size allocates nothing.
class JosephUpdate {
 public:
  void apply(Matrix& P, const MatrixRef& H, const MatrixRef& K, const MatrixRef& R);

 private:
  std::vector<Index> states_;  ///< those that are measured
  MatrixBuffer H_, P_rows_, K_rows_, T_, KR_, HP_, A_, A_columns_, measured_;
};

}  // namespace credence::internal
