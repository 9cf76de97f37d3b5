#pragma once

/// @file
/// The chi-square law behind every NEES and NIS verdict (theory, section 7).
///
/// Accurate to about 1e-13 relative up to 1e6 degrees of freedom (1e-10 is tested) and usable far beyond:
/// above 1e9 the cube-root normal law of [Wilson 1931] takes over, whose error in the normal
/// score is then below 1e-9 in the range of any test. A dof that is not finite and positive throws
/// std::invalid_argument; a statistic that is NaN gives NaN, because it is data.

namespace credence::internal {

/// P(χ²(dof) ≤ x); 0 for x ≤ 0.
double chi_square_cdf(double x, double dof);

/// P(χ²(dof) > x), accurate in the far tail where 1 − cdf is not.
double chi_square_survival(double x, double dof);

/// Density of χ²(dof) at x; 0 for x ≤ 0.
double chi_square_density(double x, double dof);

/// The x with P(χ²(dof) ≤ x) = probability, probability in [0, 1].
double chi_square_quantile(double probability, double dof);

/// The x with P(χ²(dof) > x) = probability: the upper tail without the loss of 1 − probability.
double chi_square_upper_quantile(double probability, double dof);

/// P(F > ratio), F = (χ²(dof)/dof) / (χ²(other_dof)/other_dof) of two that are independent.
double f_survival(double ratio, double dof, double other_dof);

/// min(1, 2 min(P(χ² ≤ sum), P(χ² ≥ sum))): two-sided, because a pessimistic filter fails too.
double two_sided_p_value(double sum, double total_dof);

/// An acceptance interval.
struct ChiSquareBounds {
  double lower = 0.0;
  double upper = 0.0;
};

/// Two-sided acceptance bounds of a mean of `count` values whose sum is χ²(total_dof): the equal-tailed
/// quantiles divided by count, e.g. total_dof = M n for the ANEES of M runs of an n-state filter.
///
/// Throws std::invalid_argument unless count > 0 and 0 < confidence < 1.
ChiSquareBounds mean_bounds(double total_dof, double count, double confidence);

/// E[X | X in its upper tail of the given probability], X ~ χ²(dof): dof + 2 q f(q) / probability with q the
/// upper quantile and f the density (by parts). Known as the expected shortfall.
double chi_square_upper_tail_mean(double probability, double dof);

/// E[X | X in its lower tail of the given probability]: dof − 2 q f(q) / probability.
double chi_square_lower_tail_mean(double probability, double dof);

}  // namespace credence::internal
