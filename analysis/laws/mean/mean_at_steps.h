#pragma once

#include <cstdint>
#include <map>

#include "analysis/laws/shape/vector_moments.h"
#include "core/nan.h"

namespace credence::internal {

/// How much of whitened errors is a mean that all runs share.
struct MeanAtSteps {
  double explained = 0.0;       ///< of the excess of the mean of |u|² over its dimension; 0: there is none
  double p_value = 1.0;         ///< of a mean of zero at every step
  double square = 0.0;          ///< mean of |μ|²/n
  double of_one = 0.0;          ///< how much of `square` is that of the average of μ over the steps
  double spread = 1.0;          ///< mean of tr C/n
  double spread_p_value = 1.0;  ///< of "the spread is no smaller than P": of Gaussian errors
  /// The mean of |μ|²/n over the steps of the first fifth, and over those later, with the p_value of these;
  /// NaN without such steps.
  double early_square = kNaN, later_square = kNaN, later_p_value = kNaN;

  /// Of runs that share noise, and each of which is right, |μ|² + tr C = n, and μ is another at every step.
  bool shared(double level) const;
  /// Whether the mean is one of the first fifth of the steps, and none or next to none later.
  bool passes(double level) const;
};

/// Of whitened errors u (correlation_whitening.h) at some steps over the runs, which a mean μ_k and a
/// covariance C_k make: E|u|² = |μ_k|² + tr C_k, so that a bias is all of the excess over n while P is right,
/// and a wrong P with errors of either sign is none of it. explained = Σ_k |μ_k|² / Σ_k (E|u|² − n), |μ_k|²
/// without its own error, |ū|² − tr C/M; p_value: Hotelling's T² at each step over the M runs
/// (test_zero_mean), Bonferroni over the steps; spread_p_value: of the least χ²((M − 1) n) of (M − 1) tr C,
/// likewise. A step without ten runs, or more than components, is left out; without any p_value is 1.
MeanAtSteps test_mean_at_steps(const std::map<std::int64_t, VectorMoments>& whitened);

}  // namespace credence::internal
