#pragma once

#include <vector>

#include "analysis/riccati_map.h"

/// @file
/// How a covariance grows over very many steps, by doubling (theory: section 3).

namespace credence {

/// tr P_{2^k} for k = 0, 1, …, from P0.
struct RiccatiGrowth {
  std::vector<double> traces;  ///< of P after 2^k steps; ends early when the next would not be finite
  bool overflowed = false;     ///< the covariance left 1e100, or the range of double
  bool rounded = false;        ///< ended early because rounding began to show
  Matrix P;                    ///< after 2^(traces.size() − 1) steps

  /// The number of steps that P stands for.
  double steps() const;

  /// g = log2(tr P_{2^{k+1}} / tr P_{2^k}) of the last doubling: 0 bounded, 1 linear growth; 0 for P = 0.
  double exponent() const;

  /// h = log2 of the ratio of the last two increments of the trace: 1 linear growth, however slow, −1 an
  /// approach as 1/k. 0 where the increments are not both above 1e-5 of the trace.
  double increment_exponent() const;

  /// The last increment of the trace, per step.
  double trace_per_step() const;

  /// The trace grows: by its size (g > 1/2), or steadily by its increments (h > 1/2 twice). A growth of less
  /// than about 1e-11 of the trace per step is not seen after 2^21 steps.
  bool grows() const;
};

/// Whether to watch for rounding.
enum class GrowthGuard {
  none,
  two_maps,  ///< follow P around two centres and stop where they disagree by 10⁻³; twice the time
};

/// Follows P from P0 through 2^doublings steps (theory: section 3). Never throws for a valid problem.
RiccatiGrowth riccati_growth(const RiccatiProblem& problem, const Matrix& P0, int doublings = 21,
                             GrowthGuard guard = GrowthGuard::two_maps);

}  // namespace credence
