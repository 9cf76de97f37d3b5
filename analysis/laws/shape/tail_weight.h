#pragma once

#include "analysis/laws/shape/coverage.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// Whether errors have heavier tails than Gaussian ones, so that "the covariance is right, the law is not"
/// can be said where the tests of χ² reject and those of the mean do not.
///
/// For u ~ N(0, I_n), E|u|⁴ = n (n + 2): Mardia's kurtosis (Biometrika 57, 1970), here summed over a run,
/// since steps are correlated. From K = Σ_k ε_k²/Σ_k n_k (n_k + 2) and X = Σ_k ε_k/Σ_k n_k of a run,
///
///   Y = K − 2 X + 2,
///
/// has mean 1 under consistency whatever the dependence in time, and 1 + (c − 1)² under a common factor c on
/// P: of a wrong scale it sees the second order only.

namespace credence::internal {

/// The sums of one run.
class RunTails {
 public:
  /// The next step: NEES, or NIS, and its dof.
  void add(double nees, double dof);
  /// Y of the header; NaN before the first step.
  double value() const;

 private:
  double squares_ = 0.0, expected_squares_ = 0.0;
  double sum_ = 0.0, dof_ = 0.0;
};

/// The p-value of "tails no heavier than Gaussian", small when E Y > 1: Hall's score (hall_score.h) of the Y
/// of the runs against t(M − 1). NaN for fewer than ten runs, or values that do not vary or are not finite.
///
/// Measured at 2.5 % on constant-velocity, random-walk and SLAM filters, 1,000 studies of 20, 50 and 200
/// runs: 1.5 to 3.1 %. Measurement noise of Student's t(4) and the right covariance, 50 runs: found in 96,
/// 14, 72 % of the studies, Laplace noise in 100, 5, 28 %. What a filter has averaged over many steps is
/// Gaussian again, so test NIS too. Where P is wrong by factors that vary in time, Y says so as well: read it
/// beside a mean that fits.
double heavy_tail_p_value(const SkewedMoments& run_values);

/// The p-value of "no more values lie beyond a far quantile than a wrong scale puts there", of independent
/// values as NIS: binomial where more than ten times as many as expected lie there (a scale fills a tail
/// too, but gradually: a factor 1.33 on two dof makes ten times as many beyond the 99.99 % quantile), else 1.
/// One value that is far from all others, which no mean over runs can tell from chance, shows here. Throws
/// as binomial_p_value does.
double far_tail_p_value(const CoverageCount& within, double quantile);

}  // namespace credence::internal
