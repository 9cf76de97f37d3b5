#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/types.h"

namespace credence::internal {

/// How far the claimed covariances are from the errors really made, in decibels [Li 2006].
struct CredibilityIndex {
  std::int64_t runs = 0;
  double noncredibility = 0.0;        ///< NCI: 0 for a credible filter of infinitely many runs
  double noncredibility_floor = 0.0;  ///< what a consistent filter shows with this many runs
  double inclination = 0.0;           ///< I²: above 0 optimistic, below 0 pessimistic
  double expected_inclination = 0.0;  ///< of a consistent filter with this many runs
  double lower = 0.0, upper = 0.0;    ///< interval of the inclination less its expected value
  double p_value = 0.0;               ///< that the filter is consistent, by the inclination
  std::string_view reason = {};       ///< why there is no index (numbers NaN), else empty
};

/// The noncredibility index and the inclination indicator of one step, of the errors e_i that their own
/// covariances P_i whiten to u_i (correlation_whitening.h),
///
///   NCI = (10/M) Σ |log₁₀ ρ_i|,  I² = (10/M) Σ log₁₀ ρ_i,  ρ_i = u_iᵀ u_i / u_iᵀ Σ̂⁻¹ u_i,  Σ̂ = (1/M) Σ u_i
///   u_iᵀ.
///
/// Where all runs have one P this is ρ_i = e_iᵀ P⁻¹ e_i / e_iᵀ Σ̂_e⁻¹ e_i with the covariance Σ̂_e of the
/// errors themselves [Li 2006]. Where P_i differs between runs, as with missed measurements, Σ̂_e mixes errors
/// of different laws, and no filter would be credible; u_i is N(0, I) all the same. For a consistent filter
/// E[ln ρ] = ψ(M/2) − ln(M/2) exactly, as u_iᵀ Σ̂⁻¹ u_i / M is a Beta variable. Its mean over the runs is
/// taken as the logarithm of χ²(ν)/ν, ν = n (M − 1.4), which fits its variance 2/(nM) and its skewness
/// (measured; exact for n = 1 but for the 1.4); E|ln ρ| is asymptotically 2/√(πM). errors: M vectors of
/// dimension n < M; covariances: M of them. Not positive definite or not finite: no
/// index, with a reason. Throws std::invalid_argument for sizes that differ or a confidence outside (0, 1).
CredibilityIndex credibility_index(std::span<const Vector> errors, std::span<const Matrix> covariances,
                                   double confidence);

}  // namespace credence::internal
