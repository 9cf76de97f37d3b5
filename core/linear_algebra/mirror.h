#pragma once

#include "core/types.h"

namespace credence::internal {

/// Copies the lower triangle over the upper one: a computed symmetric matrix becomes symmetric to the last
/// bit.
template <typename Derived>
void mirror_lower(Eigen::MatrixBase<Derived>& M) {
  const Index n = M.cols();
  constexpr Index kTogether = 4;  // columns: what is written lies in one line of the cache
  Index j = 0;
  for (; j + kTogether < n; j += kTogether) {
    for (Index a = 1; a < kTogether; ++a) {
      for (Index b = 0; b < a; ++b) M(j + b, j + a) = M(j + a, j + b);
    }
    for (Index i = j + kTogether; i < n; ++i) {
      for (Index a = 0; a < kTogether; ++a) M(j + a, i) = M(i, j + a);
    }
  }
  for (; j < n; ++j) {
    for (Index i = j + 1; i < n; ++i) M(j, i) = M(i, j);
  }
}

/// M ← (M + Mᵀ)/2 in place, symmetric to the last bit.
template <typename Derived>
void symmetrise(Eigen::MatrixBase<Derived>& M) {
  for (Index j = 0; j < M.cols(); ++j) {
    for (Index i = j + 1; i < M.rows(); ++i) M(i, j) = M(j, i) = 0.5 * (M(i, j) + M(j, i));
  }
}

/// (M + Mᵀ)/2.
inline Matrix symmetrised(const Matrix& M) { return 0.5 * (M + M.transpose()); }

}  // namespace credence::internal
