#pragma once

#include <span>
#include <vector>

#include "analysis/laws/shape/coverage.h"
#include "montecarlo/engine/moments.h"
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
  /// Whether K > X²: of Gaussian errors in less than half of the runs, as K/X² is skewed and a dependence in
  /// time makes it smaller, whatever the scale of P.
  bool heavier() const;

 private:
  double squares_ = 0.0, expected_squares_ = 0.0;
  double sum_ = 0.0, dof_ = 0.0;
};

/// Of all runs.
struct TailSums {
  SkewedMoments weights{};  ///< Y
  CoverageCount heavier{};  ///< of how many K > X²

  void add(const RunTails& run);
  void merge(const TailSums& later);
  bool operator==(const TailSums&) const = default;
};

/// Y of twenty equal pieces of each of few runs, of ε_k/n over its mean, so that it is the same for any scale
/// of P. Of each run the two pieces are left out where ε is largest: what is wrong at one place alone is no
/// matter of tails. dof: n, the same in all rows.
SkewedMoments tails_of_pieces(std::span<const std::vector<double>> normalised_nees, double dof);
/// The same of independent values, as NIS, by their moments at each step over the runs.
SkewedMoments tails_of_pieces(std::span<const Moments> steps, double dof);

/// The p-value of "tails no heavier than Gaussian", small when E Y > 1: Hall's score (hall_score.h) of the Y
/// against t(M − 1). NaN for fewer than ten, or values that do not vary or are not finite.
double heavy_tail_p_value(const SkewedMoments& weights);

/// The same of runs, Bonferroni with the binomial law of how many are heavier: a few outliers show in the
/// mean alone, tails that all runs share are lost in its skewness and show in their number.
///
/// Measured at 2.5 % on constant-velocity, random-walk and SLAM filters, 1,000 studies of 20, 50 and 200
/// runs: 1.5 to 3.1 %. Measurement noise of Student's t(4) and the right covariance, 50 runs: found in 96,
/// 14, 72 % of the studies, Laplace noise in 100, 5, 28 %. What a filter has averaged over many steps is
/// Gaussian again, so test NIS too. Where P is wrong by factors that vary in time, Y says so as well: read it
/// beside a mean that fits.
double heavy_tail_p_value(const TailSums& runs);

/// The p-value of "no more values lie beyond a far quantile than a wrong scale puts there", of independent
/// values as NIS: binomial where more than ten times as many as expected lie there (a scale fills a tail
/// too, but gradually: a factor 1.33 on two dof makes ten times as many beyond the 99.99 % quantile), else 1.
/// One value that is far from all others, which no mean over runs can tell from chance, shows here. Throws
/// as binomial_p_value does.
double far_tail_p_value(const CoverageCount& within, double quantile);

}  // namespace credence::internal
