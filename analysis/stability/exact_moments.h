#pragma once

#include <span>
#include <vector>

#include "core/filters/linear_filter.h"
#include "core/models/linear_model.h"

/// @file
/// The exact second moment of a suboptimal linear filter, without Monte Carlo (theory, section 3).

namespace credence::internal {

/// What a filter's error is really like after one step, and what its tests then average to.
struct ExactMoments {
  Matrix Sigma;  ///< E[e eᵀ] after the update, n×n

  double nees = 0.0;   ///< E[eᵀ P⁻¹ e] = tr(P⁻¹ Σ), on the range of P where P is singular
  Index nees_dof = 0;  ///< rank of P: the value of `nees` for a consistent filter
  /// tr of the part of Σ outside the range of P, over tr Σ: error where the filter claims certainty.
  double outside = 0.0;

  double nis = 0.0;   ///< E[νᵀ S⁻¹ ν] = tr(S⁻¹ (H Σ⁻ Hᵀ + R))
  Index nis_dof = 0;  ///< m
};

/// The moments along the steps that a filter believes in.
///
/// Σ_0 = P0 of `truth`; Σ⁻ = F Σ Fᵀ + G Q Gᵀ; Σ = (I − K H) Σ⁻ (I − K H)ᵀ + K R Kᵀ with the filter's K, S and
/// P. `steps` come from `linear_filter_steps` for the model that the filter assumes, which has the same F
/// and H as the truth. Ends before the first step that is not ok or whose NEES or NIS is not finite. Singular
/// P is legal. O(n³) a step. Throws std::invalid_argument for steps of other sizes than the model's.
std::vector<ExactMoments> exact_moments(const LinearModel& truth, const std::vector<LinearFilterStep>& steps);

/// The same for models of a period, of whose steps these are, and a filter that may have another F or H: the
/// covariance is then that of [e; x] (core/models/model_mismatch.h), with x̂_0 = 0, and Σ is its block of e.
std::vector<ExactMoments> exact_moments(std::span<const LinearModel> truth,
                                        std::span<const LinearModel> assumed,
                                        const std::vector<LinearFilterStep>& steps);

/// tr(P⁻¹ Σ) on the range of P.
struct ExpectedSquare {
  double value = 0.0;
  Index dof = 0;         ///< rank of P
  double outside = 0.0;  ///< share of tr Σ outside the range of P
};

/// E[eᵀ P⁻¹ e] for an error of covariance Σ; states are scaled to unit diagonal of P before its rank is
/// decided, and those of variance zero left out. Both n×n symmetric psd.
ExpectedSquare expected_square(MatrixRef P, MatrixRef Sigma);

/// The same after a measurement, with the variances `before` it, n: a state of which rounding alone is left
/// has no variance (core/linear_algebra/psd_root.h).
ExpectedSquare expected_square(MatrixRef P, MatrixRef Sigma, VectorRef before);

}  // namespace credence::internal
