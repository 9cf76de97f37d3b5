#pragma once

#include "core/inflation/inflation_rule.h"
#include "core/inflation/min_trace.h"
#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal {

/// The decorrelation before each update of one run, with what is remembered of the last: where the exact
/// solver ended, and the map's blocks D.
///
/// Of the map alone the least trace is guarded (theory, section 5, Theorem 3): D bounds what predictions and
/// an update make of it, so that without a new landmark it is kept where the new one has the larger trace, as
/// where the solver stops short of the optimum. Then the sum of the map's variances never rises, whatever the
/// duality gap. The pairwise sum is left as the paper has it, and a constant ΔP makes D no bound.
class InflationAlongRun {
 public:
  /// Decorrelates P, which predictions and updates alone have made of what the last call left, landmarks
  /// added at the end. A sequential rule, which inflates within the update, does nothing here. Throws as
  /// `inflate`.
  InflationStep apply(Matrix& P, const BlockLayout& layout, const InflationRule& rule,
                      const MinTraceOptions& options = {});

  /// Forgets: the next P is of another run.
  void reset() { *this = {}; }

 private:
  MinTraceState warm_start_;
  Matrix blocks_;       ///< D of the last step, d×n_f, its blocks side by side; empty where it is no bound
  double trace_ = 0.0;  ///< tr D
};

}  // namespace credence::internal
