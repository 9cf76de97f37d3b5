#pragma once

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal {

/// Throws std::invalid_argument for an A that is not of the size of `layout`.
void require_layout(const MatrixRef& A, const BlockLayout& layout);

/// Makes A block diagonal, in place, by the pairwise sum E_j = Σ_k (A_jk A_jkᵀ)^{1/2} (theory, section 4).
///
/// The blocks of A are those of `layout`; layout.vehicle = 0 means landmarks only. A is symmetric and stays
/// so to the last bit; its off-diagonal blocks become exact zeros. O(n²) for landmark blocks up to 3×3,
/// without allocation there. Correlations below 1e-154 may be taken for zero. Throws std::invalid_argument
/// for an A of another size.
void decorrelate_pairwise(Eigen::Ref<Matrix> A, const BlockLayout& layout);

}  // namespace credence::internal
