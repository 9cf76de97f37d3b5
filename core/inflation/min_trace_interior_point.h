#pragma once

#include <vector>

#include "core/types.h"

namespace credence::internal {

/// One diagonal block: its first row and its size.
struct DiagonalBlock {
  Index offset;
  Index size;
};

/// An iterate near the central path of the minimal-trace problem of core/inflation/min_trace.h.
struct MinTraceInteriorPoint {
  Matrix E;  ///< block diagonal with E − O ≻ 0
  Matrix X;  ///< X ≻ 0 with X_jj = I to rounding
  Index steps = 0;
};

/// Solves min tr E, E − O ⪰ 0, and its dual max ⟨O, X⟩, X ⪰ 0, X_jj = I, by primal-dual steps [Helmberg 1996]
/// with the corrector of [Mehrotra 1992], from X = I and an E with E − O ≻ 0.
///
/// O is symmetric with zero diagonal blocks. Ends when ⟨E − O, X⟩ ≤ relative_gap · tr E or when it no longer
/// falls; what was reached is for the caller to measure. O(m³) a step, about 15 steps.
MinTraceInteriorPoint min_trace_interior_point(const Matrix& O, const std::vector<DiagonalBlock>& blocks,
                                               const Matrix& E, double relative_gap);

}  // namespace credence::internal
