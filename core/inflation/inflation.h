#pragma once

#include "core/inflation/min_trace.h"
#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence {

/// Which blocks the added pseudo-noise ΔP decorrelates (theory, section 4).
enum class Inflation {
  none,  ///< ΔP = 0, the optimal filter
  full,  ///< vehicle block and every landmark block: P + ΔP is block diagonal
  map,   ///< landmark blocks only: the correlations of the vehicle with the map are kept
};

/// How ΔP is chosen among those that decorrelate.
enum class InflationSolution {
  pairwise,    ///< the sum of the two-block bounds over all pairs
  min_trace,   ///< the exact minimum of tr ΔP, by its dual
  sequential,  ///< the exact closed form after each scalar measurement, O(N)
  batch,       ///< a bound after each batch of scalar measurements, O(N)
  drop,        ///< sequential, but no landmark keeps any of its reduction, O(N)
};

/// Adds to the covariance P, in place, the ΔP ⪰ 0 that makes the chosen blocks of P + ΔP block diagonal.
///
/// With blocks C_jk off the diagonal of P, ΔP = E − offdiag(P) on the chosen set and zero elsewhere, where
/// pairwise takes E_j = Σ_k (C_jk C_jkᵀ)^{1/2} and min_trace the E of least trace (theory, section 4).
/// P is n×n symmetric psd, n = layout.state_dim(); its symmetry is kept exactly. Throws std::invalid_argument
/// for a P of another size, and for `sequential`, `batch` and `drop`, which are rules within an update and
/// not maps of P.
void inflate(Matrix& P, const internal::BlockLayout& layout, Inflation inflation, InflationSolution solution);

/// What one call of `inflate` did to P.
struct InflationStep {
  double added_trace = 0.0;   ///< tr ΔP
  double relative_gap = 0.0;  ///< min_trace: proven distance of the trace from the minimum; else 0
  bool converged = true;      ///< min_trace: the gap is the one asked for
  bool kept = false;          ///< InflationAlongRun: the blocks of the step before were kept
};

/// The same, faster along a run: min_trace starts from where the last step ended, kept in `state` by the
/// caller (one per run), and returns its certificate: a verdict on boundedness needs `converged`.
InflationStep inflate(Matrix& P, const internal::BlockLayout& layout, Inflation inflation,
                      InflationSolution solution, internal::MinTraceState& state,
                      const internal::MinTraceOptions& options = {});

}  // namespace credence
