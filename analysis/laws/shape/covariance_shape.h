#pragma once

#include <string_view>

#include "analysis/laws/shape/vector_moments.h"
#include "core/nan.h"
#include "core/types.h"

/// @file
/// Whether the true covariance Σ is P in every direction, from the whitened errors u
/// (correlation_whitening.h) of independent runs at ONE step: NEES sees tr(P⁻¹ Σ) only, and an x too small
/// may hide a y too large.
///
/// With C = Σ u uᵀ/M (about zero) the likelihood ratio of Σ = P is LR = M (tr C − ln det C − n); it sees
/// every scale, sign and cross term (T. W. Anderson, "An Introduction to Multivariate Statistical Analysis",
/// 3rd ed., section 10.8, mean known). Asymptotically χ²(n(n + 1)/2). For Gaussian errors all its cumulants
/// are known, as E e^{t LR} is a ratio of multivariate gamma functions:
///
///   κ₁ = −M (Σ_i ψ(h_i) + n ln(2/M)),  κ₂ = M² Σ_i ψ'(h_i) − 2 n M,  κ₃ = −M³ Σ_i ψ''(h_i) − 4 n M,
///   h_i = (M − i + 1)/2, i = 1 … n,
///
/// and the law is taken as χ² shifted and scaled to these three (chi_square_cumulants.h): measured over
/// 40,000 samples, n = 1 … 12, M = n + 1 … 20 n, 4.7 to 5.3 % at 5 % and 0.9 to 1.1 % at 1 %. Bartlett's
/// correction, which matches the first alone, has 7.8 % at n = 12, M = 13, and the plain χ² law 95 %.
/// Assumed: Gaussian errors, independent runs.

namespace credence::internal {

/// The factors between Σ and P over all directions: eigenvalues of P^{-1/2} Σ P^{-T/2}, which those of C
/// estimate.
struct CovarianceShape {
  double p_value = kNaN;  ///< of Σ = P
  Vector factors = {};    ///< eigenvalues of C, ascending
  double proved_within =
      kNaN;  ///< δ: every factor is in [1/(1 + δ), 1 + δ] at this confidence; may be infinite
  std::string_view reason = {};  ///< why there is no test (numbers NaN), else empty
};

/// Tests the errors of one step, or of one average that is N(0, I) under consistency. Needs more runs than
/// components.
///
/// With a the direction of the largest factor, λ_max(C) ≥ aᵀ C a = λ_max(Σ) χ²(M)/M, so that λ_max(Σ) ≤
/// λ_max(C) M / q_α at confidence 1 − α, exact or conservative; the same below. proved_within takes both
/// one-sided tests at α (what is proved is the intersection, so no level is shared, neither between the sides
/// nor between the directions). About M = 8 n/δ² runs prove δ. Throws std::invalid_argument unless 0 <
/// confidence < 1.
CovarianceShape test_covariance_shape(const VectorMoments& whitened, double confidence);

}  // namespace credence::internal
