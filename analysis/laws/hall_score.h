#pragma once

#include "montecarlo/engine/skewed_moments.h"

/// @file
/// A test of a mean that removes the skewness of the sample (P. Hall, "On the removal of skewness by
/// transformation", J. R. Stat. Soc. B 54, 1992):
///
///   √M ((1 + γ U/3)³ − 1)/γ + γ/(6 √M),  U = (x̄ − μ)/s,
///
/// γ the sample skewness. It is N(0, 1) up to O(1/M), where Student's score errs by O(1/√M), and monotone in
/// μ.

namespace credence::internal {

/// γ = (m₃/M)/(m₂/M)^{3/2}; 0 without a variance.
double sample_skewness(const SkewedMoments& moments);

/// The score of the hypothesis that the mean is `expected`: large when the sample mean is. Not finite without
/// a variance.
double hall_score(const SkewedMoments& moments, double expected);

/// The mean whose score is z.
double mean_of_hall_score(const SkewedMoments& moments, double z);

}  // namespace credence::internal
