#pragma once

#include "analysis/laws/mean/student.h"
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

/// The score of the hypothesis that the mean is `expected`, for values of this skewness: large when the
/// sample mean is. Not finite without a variance.
double hall_score(const SkewedMoments& moments, double expected, double skewness);
/// The same, of the sample skewness.
double hall_score(const SkewedMoments& moments, double expected);

/// The mean whose score is z, for values of this skewness.
double mean_of_hall_score(const SkewedMoments& moments, double z, double skewness);
/// The same, of the sample skewness.
double mean_of_hall_score(const SkewedMoments& moments, double z);

/// The interval of the means whose score Student's quantile of M − 1 dof accepts: Student's own interval of
/// two values, and of more one that follows their skewness. Reasons and errors as student_interval.
///
/// Share of intervals without the mean, in % at nominal 5 % (20,000 studies up to M = 10, 1,000 at 200): of
/// the log score of exact filters (SLAM of 1 and 5 landmarks, 100 steps; constant velocity; χ²₁) and the
/// CRPS,
///
/// | M   | Student's  | this       |
/// |-----|------------|------------|
/// | 3   | 5 … 18     | 5 … 13     |
/// | 5   | 5 … 17     | 5 … 11     |
/// | 10  | 5 … 14     | 5 … 7.4    |
/// | 20  | 5 … 11     | 4.6 … 6.2  |
/// | 50  | 5 … 7.3    | 3.7 … 5.4  |
/// | 200 | 3.3 … 6.6  | 3.4 … 5.9  |
MeanInterval hall_interval(const SkewedMoments& moments, double confidence);

/// The interval of the means that this score or Student's accepts: of differences between two filters in the
/// same noise, which may be as skewed as squared errors, or not at all. Reasons and errors as
/// student_interval.
///
/// Share of intervals without the mean, in % at nominal 5 %, of filters of scenarios/linear_estimators.toml
/// less the first, 100 steps, 60,000 runs in groups of M:
///
/// | M       | NEES, Student's | this      | squared errors, Student's | this       |
/// |---------|-----------------|-----------|---------------------------|------------|
/// | 2       | 4.1 … 5.0       | the same  | 6.5 … 14.7                | the same   |
/// | 3, 5    | 3.9 … 6.0       | 2.5 … 4.8 | 8.4 … 18.1                | 5.6 … 11.4 |
/// | 10      | 4.0 … 6.5       | 3.3 … 5.3 | 8.5 … 14.1                | 5.9 … 7.5  |
/// | 20      | 4.2 … 6.4       | 4.0 … 5.5 | 7.4 … 10.8                | 4.8 … 5.7  |
/// | 50, 100 | 4.1 … 6.9       | 4.0 … 6.8 | 5.2 … 8.4                 | 3.4 … 4.5  |
MeanInterval paired_interval(const SkewedMoments& differences, double confidence);

/// That the mean is zero: the larger p-value of both scores. NaN for fewer than two values; of equal ones 1
/// if they are zero, else 0.
double paired_p_value(const SkewedMoments& differences);

}  // namespace credence::internal
