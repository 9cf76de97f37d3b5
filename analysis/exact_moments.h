#pragma once

#include <span>
#include <vector>

#include "core/linear_filter.h"
#include "core/linear_model.h"

namespace credence {

/// Exact expectations at one step of a linear filter, suboptimal or not.
struct ExactMoments {
  Matrix Sigma_prior;  ///< true covariance of the error before the update
  Matrix Sigma;        ///< and after it
  double nees = 0.0;   ///< E[NEES] = tr(P⁻¹ Σ)
  double nis = 0.0;    ///< E[NIS] = tr(S⁻¹ (H Σ⁻ Hᵀ + R))
};

/// What a Monte Carlo study of a linear filter must find (theory: section 3):
///   Σ⁻ = F Σ⁺ Fᵀ + G Q Gᵀ (no ΔP),  Σ⁺ = (I − K H) Σ⁻ (I − K H)ᵀ + K R Kᵀ
/// with the noise of `truth` and the gains of `steps`. Ends before the first step that is not ok.
std::vector<ExactMoments> exact_moments(const LinearModel& truth, std::span<const LinearFilterStep> steps);

}  // namespace credence
