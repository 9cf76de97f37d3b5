#pragma once

#include "core/record/normalised_step.h"
#include "montecarlo/engine/moments.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// Proper scores of the error under the law N(0, P) that the filter claims (proper_scores.h): which of two
/// filters is better, where a test says only whether one is right.

namespace credence::internal {

/// A score over runs beside what it would be on average if P were right.
struct ScoreMoments {
  SkewedMoments value;
  Moments expected;

  void merge(const ScoreMoments& later) {
    value.merge(later.value);
    expected.merge(later.expected);
  }
};

/// Over the runs that ended well.
struct ScoreSums {
  ScoreMoments log;     ///< of the whole state, averaged over the steps of each run; a P of full rank
  ScoreMoments energy;  ///< at the end of each run: of the position in its unit, or of the whitened state
  bool of_position = false;

  void merge(const ScoreSums& later);
};

/// Of the run at hand.
struct RunScore {
  double log = 0.0, log_expected = 0.0;
  Index steps = 0;
  double last_nees = 0.0;
  Index last_dof = 0;
  BlockError last_position{};

  /// The next step of the whole state. log_determinant: of P; NaN where that is of lower rank.
  void add(double nees, Index dof, double log_determinant);
  void add_to(ScoreSums& sums) const;
};

}  // namespace credence::internal
