#pragma once

#include "core/types.h"

namespace credence::internal {

/// M = U diag(s) Vᵀ with s falling; U or V complete to a square where the full one is asked for.
struct DenseSvd {
  Matrix U, V;
  Vector s;
};

/// Which singular vectors are wanted.
enum class SvdVectors { none, left, right, full_left, full_right };

/// The singular values of any M, with no or one side of vectors; M may have no rows or no columns.
///
/// One place that compiles Eigen's divide-and-conquer SVD, which is dear to compile.
DenseSvd dense_svd(MatrixRef M, SvdVectors vectors = SvdVectors::none);

}  // namespace credence::internal
