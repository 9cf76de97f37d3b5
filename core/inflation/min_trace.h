#pragma once

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal {

/// What the caller keeps from one call to the next, so that the next starts where the last ended.
///
/// Landmarks that were appended since are started afresh; for any other change of layout all is. The result
/// is the same within its gap, but not in its last bits: keep one state per run, never share it.
struct MinTraceState {
  BlockLayout layout;
  Matrix V;  ///< dual factors, p×m: the columns of each block are orthonormal and X = VᵀV
};

/// How exact the minimal trace is to be, and what it may cost.
struct MinTraceOptions {
  /// Bound on (primal − dual)/primal, in (0, 1), that counts as converged; a tenth of it is aimed at.
  double relative_gap = 1e-9;
  Index max_sweeps = 1000;  ///< of the ascent over the blocks
  /// Largest m for which an ascent that crawls is finished by interior-point steps, O(m³) each.
  Index max_interior_point_dim = 500;
};

/// The exact minimal-trace bound E with its certificate; all numbers are computed, none assumed.
struct MinTraceBound {
  Matrix E;           ///< m×m, block diagonal, E − offdiag(A) ⪰ 0 (feasible also when not converged)
  double primal = 0;  ///< tr E, the trace that the inflation adds
  double dual = 0;    ///< ⟨offdiag(A), X⟩ of a feasible X: no valid E has a smaller trace
  double relative_gap = 0;  ///< (primal − dual)/primal, 0 when primal = 0
  Index sweeps = 0;         ///< of the block ascent
  Index interior_point_steps = 0;
  bool converged = false;  ///< relative_gap ≤ the one wanted
};

/// min tr E subject to E − offdiag(A) ⪰ 0, E block diagonal (theory, section 4).
///
/// A is m×m symmetric, m = layout.state_dim(), its blocks those of `layout`; layout.vehicle = 0 means
/// landmarks only. Only the off-diagonal blocks are read. Dual: max ⟨offdiag(A), X⟩, X ⪰ 0, X_jj = I, by
/// block-coordinate ascent on X = VᵀV; where that crawls (nearly balanced correlations), by primal-dual
/// interior-point steps. The E returned is made feasible by a shift along its own diagonal with the least
/// eigenvalue, which the primal includes, and is the pairwise bound itself where no smaller one is found.
/// About 2 p m² operations per sweep, p ~ √(2 m), and an eigenvalue decomposition. Throws
/// std::invalid_argument for an A of another size or impossible options; an A that is not finite gives an E
/// of NaN, not converged.
MinTraceBound min_trace_bound(const MatrixRef& A, const BlockLayout& layout,
                              const MinTraceOptions& options = {}, MinTraceState* state = nullptr);

/// Makes A block diagonal, in place, by the exact bound; returns the bound. Off-diagonal blocks become zeros.
MinTraceBound decorrelate_min_trace(Eigen::Ref<Matrix> A, const BlockLayout& layout,
                                    const MinTraceOptions& options = {}, MinTraceState* state = nullptr);

}  // namespace credence::internal
