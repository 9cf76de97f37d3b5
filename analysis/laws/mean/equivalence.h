#pragma once

#include "analysis/laws/mean/run_mean.h"

/// @file
/// Consistency that is proved, and not only not refuted: the mean of X lies within [1/(1 + δ), 1 + δ].
///
/// Two one-sided tests (D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987): "mean ≥ 1 + δ" and "mean ≤
/// 1/(1 + δ)" are both rejected at α, by the tests of run_mean.h. What is claimed is the intersection, so no
/// level is shared: it is proved iff the interval of confidence 1 − 2α lies inside. A mean of NEES: of
/// P⁻¹ Σ averaged over directions and steps, and not of every direction (covariance_shape.h proves that).

namespace credence::internal {

/// The p-value of "the mean lies outside [1/(1 + δ), 1 + δ]": proved within δ iff it is ≤ α. NaN as
/// run_mean_p_values. Throws as that, and unless δ > 0 is finite.
double equivalence_p_value(const SkewedMoments& run_averages, double delta);

/// The least δ that is proved at this confidence; infinite if none is, NaN without runs, or at ½.
/// Throws as run_mean_interval, and unless ½ ≤ confidence < 1.
double proved_within(const SkewedMoments& run_averages, double confidence);

}  // namespace credence::internal
