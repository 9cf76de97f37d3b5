#pragma once

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal {

/// The two square roots that belong to one off-diagonal block C: what decorrelating two blocks costs each.
///
/// [left, −C; −Cᵀ, right] ⪰ 0, and of all such pairs this one has the least trace, 2‖C‖_* (theory, section
/// 4).
struct TwoBlockBound {
  Matrix left;       ///< (C Cᵀ)^{1/2}, rows(C) × rows(C)
  Matrix right;      ///< (Cᵀ C)^{1/2}, cols(C) × cols(C)
  double trace = 0;  ///< the added trace, 2‖C‖_*
};

/// The exact minimal-trace bound of two blocks whose correlation is C, any shape (theory, section 4).
TwoBlockBound two_block_bound(const MatrixRef& C);

/// Makes A block diagonal, in place, by the pairwise sum E_j = Σ_k (A_jk A_jkᵀ)^{1/2} (theory, section 4).
///
/// The blocks of A are those of `layout`; layout.vehicle = 0 means landmarks only. A is symmetric and stays
/// so to the last bit; its off-diagonal blocks become exact zeros. O(n²) for landmark blocks up to 3×3,
/// without allocation there. Correlations below 1e-154 may be taken for zero. Throws std::invalid_argument
/// for an A of another size.
void decorrelate_pairwise(Eigen::Ref<Matrix> A, const BlockLayout& layout);

/// Makes A block diagonal, in place, by block diagonal dominance: E_j = (Σ_k ‖A_jk‖₂) I.
///
/// The crudest valid bound, for comparison: equal to the pairwise sum for scalar blocks, above it otherwise.
/// Preconditions and errors as for decorrelate_pairwise.
void decorrelate_by_dominance(Eigen::Ref<Matrix> A, const BlockLayout& layout);

}  // namespace credence::internal
