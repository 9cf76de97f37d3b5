#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/correlation/whiteness.h"
#include "analysis/laws/shape/goodness_of_fit.h"
#include "analysis/tuning/noise_scale.h"
#include "core/types.h"

/// @file
/// What the innovations of one or a few recorded runs tell of the noise that a filter assumes.
///
/// There are no repetitions to average over, so every test here says what it assumes, and gives no result,
/// with a reason, where a recording is too short for it.

namespace credence::internal {

/// The innovations of one run.
struct RecordedInnovations {
  /// νᵀ S⁻¹ ν of the values tested, each of `dof`, in order of time; independent for a consistent filter.
  std::vector<double> nis;
  double dof = 2.0;
  std::vector<Vector> whitened;  ///< L⁻¹ ν of all innovations used, S = L Lᵀ, all of one dimension
};

/// All tests of the innovations of one run or of several independent ones.
struct InnovationTests {
  ConsistencyVerdict nis;                ///< of their sum; assumes that they are white
  GoodnessOfFit fit;                     ///< against the χ² law; assumes it too
  WhitenessTest whiteness;               ///< lags 1 to 10
  Vector mean;                           ///< of the whitened innovation, in standard deviations
  double mean_p_value = 0.0;             ///< Hotelling's T² over stretches; NaN where it is not made
  NoiseScale noise_scale;                ///< assumes neither whiteness nor a law
  std::vector<double> adjusted_p_value;  ///< Holm over: sum, fit, whiteness, mean
};

/// Tests the innovations of independent runs of one of so many sensors (Bonferroni; the interval of the scale
/// is of this one alone). The scale has no interval where part of the innovations stays in whole runs and
/// there are fewer than ten. Throws std::invalid_argument for dofs that differ between runs, or a confidence
/// outside (0, 1).
InnovationTests test_recorded_innovations(std::span<const RecordedInnovations> runs, double confidence,
                                          std::int64_t sensors = 1);

}  // namespace credence::internal
