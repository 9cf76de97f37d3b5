#pragma once

#include <cstdint>
#include <map>

#include "analysis/laws/shape/vector_moments.h"

namespace credence::internal {

/// How much of whitened errors is a mean that all runs share.
struct MeanAtSteps {
  double explained = 0.0;  ///< of the excess of the mean of |u|² over its dimension; 0: there is none
  double p_value = 1.0;    ///< of a mean of zero at every step
};

/// Of whitened errors u (correlation_whitening.h) at some steps over the runs, which a mean μ_k and a
/// covariance C_k make: E|u|² = |μ_k|² + tr C_k, so that a bias is all of the excess over n while P is right,
/// and a wrong P with errors of either sign is none of it. explained = Σ_k |μ_k|² / Σ_k (E|u|² − n), |μ_k|²
/// without its own error, |ū|² − tr C/M; p_value: Hotelling's T² at each step over the M runs
/// (test_zero_mean), Bonferroni over the steps. A step without ten runs, or more than components, is left
/// out; without any p_value is 1.
MeanAtSteps test_mean_at_steps(const std::map<std::int64_t, VectorMoments>& whitened);

}  // namespace credence::internal
