#pragma once

#include "analysis/laws/mean/student.h"

/// @file
/// The mean of positive values with a long right tail, such as NEES summed over a run or squared errors, when
/// their law is not known.
///
/// Student's t is off for such values: with 20 runs of χ²(2) it rejects a true mean in 8.4 % of all studies
/// at nominal 5 %, and in 3.5 % at 1 %. Here the mean is taken as gamma with its shape estimated from the
/// data; the cube root of a gamma variable is nearly normal ([Wilson 1931]), and the score
///
///   z = ((x̄/μ)^{1/3} − (1 − c)) / √c,  c = 2 / (9 ν),  ν = 2 M (x̄²/s² − 1/M)
///
/// is compared with t(M − 1), as s is estimated (x̄²/s² − 1/M: for gamma values E[s²/x̄²] = 1/(shape + 1/M)
/// exactly). Measured over 20,000 studies of M = 10, 20, 50, 200 values of χ²(2), χ²(5), χ²(20): between 5.1
/// and 5.8 % at 5 %, between 0.9 and 1.3 % at 1 %. Two-sided; an approximation for laws that are not gamma.

namespace credence::internal {

/// The score z of the hypothesis that the mean is `expected`: large when the sample mean is. For at least two
/// values of positive mean and variance, else NaN.
double positive_mean_score(const Moments& moments, double expected);

/// The mean whose score is z, under the same conditions; infinite where no mean has so low a score.
double mean_of_positive_score(const Moments& moments, double z);

/// The p-value of the hypothesis that the mean is `expected`. NaN without a variance: fewer than two values,
/// values that are not finite, or a mean that is not positive; for a zero variance 1 if the mean is
/// `expected`, else 0. Throws std::invalid_argument unless expected > 0.
double positive_mean_p_value(const Moments& moments, double expected);

/// The interval of all means that this test does not reject; its upper end is infinite when the values are so
/// few and scattered that no mean is too large. Reasons and errors as student_interval.
MeanInterval positive_mean_interval(const Moments& moments, double confidence);

}  // namespace credence::internal
