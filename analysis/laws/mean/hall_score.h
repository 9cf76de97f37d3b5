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

/// The interval of the means whose score Student's quantile accepts, of M − 1 dof, and of half as many where
/// M < 20, as of few skewed values the large ones may be missing, and with them most of the variance. Reasons
/// and errors as student_interval.
///
/// Share of intervals without the mean, in % at nominal 5 %, least … largest over χ²(1), χ²(2), χ²(5),
/// χ²(20), 0.2 χ²(1) + 0.8 χ²(40)/40, a normal law and the CRPS of one (numpy, 40,000 studies); from M = 50
/// on of the log score of exact filters (SLAM of 1 and 5 landmarks, 100 steps; constant velocity; χ²₁) and
/// the CRPS (1,000 studies of 200):
///
/// | M   | by M − 1 dof | this      |
/// |-----|--------------|-----------|
/// | 2   | 4.8 … 14.7   | 0.3 … 2.1 |
/// | 3   | 4.9 … 12.6   | 1.1 … 6.2 |
/// | 5   | 5.3 … 9.9    | 1.7 … 5.5 |
/// | 7   | 5.3 … 8.2    | 2.2 … 4.9 |
/// | 10  | 5.2 … 7.0    | 2.8 … 4.3 |
/// | 15  | 4.7 … 6.7    | 3.2 … 4.7 |
/// | 20  | 4.6 … 6.7    | the same  |
/// | 50  | 3.7 … 5.4    | the same  |
/// | 200 | 3.4 … 5.9    | the same  |
MeanInterval hall_interval(const SkewedMoments& moments, double confidence);

/// The interval of the means that this score or Student's accepts, by the same quantile: of differences
/// between two filters in the same noise, which may be as skewed as squared errors, or not at all. Reasons
/// and errors as student_interval.
///
/// Share of intervals without the mean, in % at nominal 5 %, least … largest over nine laws of differences of
/// squared Gaussian errors (numpy, 40,000 studies): χ²(1), χ²(2), χ²(5) and χ²(20) less their means, 0.2
/// χ²(1) + 0.8 χ²(40)/40, x² − y², 1.2 x² − y² of independent ones, 2 x² − y² of correlation 0.9, 1.1 x² − y²
/// of two components and 0.99.
///
/// | M  | by M − 1 dof | this      |
/// |----|--------------|-----------|
/// | 2  | 3.1 … 14.9   | 0.2 … 2.1 |
/// | 3  | 1.4 … 11.3   | 0.2 … 4.4 |
/// | 5  | 1.6 … 10.7   | 0.2 … 5.2 |
/// | 7  | 2.6 … 9.6    | 0.5 … 5.9 |
/// | 10 | 3.4 … 8.3    | 1.3 … 6.0 |
/// | 15 | 4.0 … 6.7    | 2.3 … 5.3 |
/// | 20 | 4.2 … 5.9    | the same  |
///
/// Of filters of scenarios/linear_estimators.toml less the first, 100 steps, 60,000 runs in groups of M:
///
/// | M       | NEES, Student's | this      | squared errors, Student's | this       |
/// |---------|-----------------|-----------|---------------------------|------------|
/// | 20      | 4.2 … 6.4       | 4.0 … 5.5 | 7.4 … 10.8                | 4.8 … 5.7  |
/// | 50, 100 | 4.1 … 6.9       | 4.0 … 6.8 | 5.2 … 8.4                 | 3.4 … 4.5  |
MeanInterval paired_interval(const SkewedMoments& differences, double confidence);

/// That the mean is zero: the larger p-value of both scores. NaN for fewer than two values; of equal ones 1
/// if they are zero, else 0.
double paired_p_value(const SkewedMoments& differences);

}  // namespace credence::internal
