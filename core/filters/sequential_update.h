#pragma once

#include "core/inflation/rank_one_bound.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal {

/// What sequential_update works with, kept by the caller so that a step allocates nothing.
struct SequentialWorkspace {
  MatrixBuffer reduction, combination, blocks;
};

/// One batch update by scalar measurements in turn, each followed by the exact O(N) inflation of the map
/// (theory, section 5, `sequential`) or its dropping bound, or by the bound of the whole batch: P_ff stays
/// block diagonal, vehicle and vehicle-map terms are exact.
///
/// P is the prior, n×n, with the landmark blocks of `layout` uncorrelated; it becomes the posterior. H is
/// m×n, the measurement noise is diagonal with variances r. K (n×m) receives the gain of the whole batch with
/// respect to the innovation at the prior. Returns false, with P and K not to be used, when a scalar
/// innovation variance is not positive.
bool sequential_update(Matrix& P, const BlockLayout& layout, const MatrixRef& H, const VectorRef& r,
                       Eigen::Ref<Matrix> K, SequentialWorkspace& workspace, MapBound bound);

}  // namespace credence::internal
