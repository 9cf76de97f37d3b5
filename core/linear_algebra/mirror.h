#pragma once

#include "core/types.h"

namespace credence {

/// Copies the lower triangle over the upper one: a computed symmetric matrix becomes symmetric to the last
/// bit.
template <typename Derived>
void mirror_lower(Eigen::MatrixBase<Derived>& M) {
  for (Index j = 0; j < M.cols(); ++j) {
    for (Index i = j + 1; i < M.rows(); ++i) M(j, i) = M(i, j);
  }
}

/// M ← (M + Mᵀ)/2 in place, symmetric to the last bit.
template <typename Derived>
void symmetrise(Eigen::MatrixBase<Derived>& M) {
  for (Index j = 0; j < M.cols(); ++j) {
    for (Index i = j + 1; i < M.rows(); ++i) M(i, j) = M(j, i) = 0.5 * (M(i, j) + M(j, i));
  }
}

}  // namespace credence
