#pragma once

#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "core/types.h"
#include "montecarlo/engine/moments.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// How many independent steps the NEES of a run is worth, and tests of its average over time.
///
/// NEES is correlated in time: for jointly Gaussian errors Cov(ε_k, ε_l) = 2 ‖C_kl‖_F² with C_kl the
/// correlation of the whitened errors at steps k and l. Summed over a run its variance is 2 Σ_kl ‖C_kl‖_F²,
/// and not 2 Σ n_k, which is why the time-sum is no χ²(Σ n_k) (theory, section 7).

namespace credence::internal {

/// The law of the average NEES of a run.
struct RunMeanLaw {
  double effective_steps = 0.0;  ///< independent steps with the same variance, T · 2 Σ n_k / Var(Σ_k ε_k)
  double skewness = 0.0;
};

/// The exact one of a linear filter whose error moves as e_k = A_k e_{k−1} + noise with covariance P_k: C_kl
/// = W_k A_k … A_{l+1} P_l W_lᵀ with W_k P_k W_kᵀ = I on the range of P_k. As the error is a Markov process,
/// of the third cumulant 8 Σ_jkl tr(C_jk C_kl C_lj) each term with j ≤ k ≤ l is ‖C_lj‖², whatever k: the
/// cumulants are 2 Σ_k n_k + 4 Σ_{k<l} ‖C_lk‖² and 8 Σ_k n_k + 48 Σ_{k<l} (l − k) ‖C_lk‖².
///
/// transitions[k] = A_k = (I − K_k H) F (transitions[0] is not used), covariances[k] = P_k. For a consistent
/// filter P_k is both the claimed and the true covariance. Cost T n³. Throws std::invalid_argument for sizes
/// that differ or a P that is not positive semidefinite.
RunMeanLaw linear_run_law(std::span<const Matrix> transitions, std::span<const Matrix> covariances);

/// The integrated autocorrelation time of a series with known mean, in steps, and what follows from it.
struct EffectiveSample {
  double correlation_time = 0.0;  ///< τ = 1 + 2 Σ ρ_h, at least 1; NaN without data
  double size = 0.0;              ///< length / τ
  std::string_view reason = {};   ///< why there is none, else empty
};

/// τ summed over the window of [Sokal 1989], the least W ≥ 5 τ(W). Pools several series (runs of one filter):
/// their products are averaged before the sum. The mean is not estimated, so that single short runs are not
/// biased. A series whose deviations are all zero, or none, gives a reason.
EffectiveSample effective_sample(std::span<const std::span<const double>> series, double mean);

/// The same of several series about their common mean.
EffectiveSample effective_sample(std::span<const std::vector<double>> series);

/// The mean of the values; NaN of none.
double average_of(std::span<const double> values);

/// The same of one series about its own mean, so that it does not depend on the scale of the values.
EffectiveSample effective_sample(std::span<const double> series);

/// τ of the squares of jointly Gaussian errors by what the errors themselves tell, 1 + 2 Σ_h ‖R_h‖²/n, R_h
/// their correlation at lag h once they are whitened over the runs, without what noise adds, n τ/N at each
/// lag of N vectors, summed over the least window W ≥ 5 τ. Of one run of 400 constant velocities it spreads a
/// third as much as the τ of their squares, and is no shorter where these are small by chance, so that it
/// does not choose the runs whose mean is tested. errors: of each run, one a column. In columns; NaN of none,
/// and where they are not of full rank. Cost N n² W.
double memory_of_squares(std::span<const Matrix> errors);

/// length / τ of a series about its own mean, without its bias: some ten too many as the mean is estimated
/// from the same values (its square is missing in 2 W = 10 τ products), and some ten as the inverse of an
/// estimate is too large. Measured: 17 to 28 of autoregressions worth 10 to 1000 values. At least 1.
double unbiased_size(double length, double correlation_time);

/// How much of the mean square of whitened errors is that of their averages over whole runs, in the direction
/// where it is most; both n×n. An error that is forgotten leaves nothing of it, n τ/T of T rows; one that
/// stays as it is, as of a landmark, a bias, or where nothing tells the place of the whole map, leaves 1,
/// however small it happens to be. NEES does not tell such an error from a wrong P, and its correlation time
/// does not show it.
double standing_share(const Matrix& mean_square, const Matrix& square_of_means);

/// The same of an oscillation: how much of the mean square of the errors, in the direction where it is most,
/// sinusoids of one frequency have that are fitted to each tenth of the run, at the frequency where it is
/// most. An oscillation that is not damped, as of Schuler's pendulum, leaves 1, whatever its size, and its
/// NEES has no correlation time. errors: evenly over the run, one a column; 0 with fewer than 40.
double oscillating_share(const MatrixRef& errors);
/// The directions in which it looks, of each tenth.
inline constexpr Index kOscillatingStretches = 20;

/// From this share on stretches of a run are not independent, where chance makes none as large. Measured on
/// 200 runs of 200 to 2000 rows that test_single_run would test: at most 0.15 of filters that forget (1 to 12
/// states), at least 0.66 in 99 % of a SLAM without an anchor.
inline constexpr double kStandingErrors = 0.4;

/// The same of stretches of runs that are worth so many rows together (EffectiveSample::size): the most that
/// errors that are all forgotten alike leave by chance in one of many directions, θ = sin²(a(p) + a(q)), a(x)
/// = asin √((x − ½)/(N − 1)), the centre of the largest root of [Johnstone 2008] for p directions, q
/// stretches and N rows, plus a third of what is left to 1, and at least kStandingErrors. NEES forgets faster
/// than the errors: N = 0.6 of its effective rows, by which θ is within 0.05 of the median of autoregressions
/// (φ 0.5 and 0.8, 500 and 2000 rows, 12 to 40 directions), 0.08 above it where 40 directions meet 140 rows.
double least_standing_share(Index directions, Index stretches, double effective_rows);

/// Into how many equal stretches each of so many runs is cut for at least twenty in all; 0 of none, or of
/// twenty and more, which are enough.
std::size_t stretches_of_each(std::size_t runs);

/// The averages of equal stretches of a few long runs.
struct StretchAverages {
  SkewedMoments averages{};
  double effective_rows = 0.0;    ///< that the runs are worth together
  double correlation_time = 1.0;  ///< in rows
};

/// Each of ε_k / n_k: at least twenty in all (stretches_of_each), so that their mean is compared by the
/// scores of run_mean.h where the runs alone are too few; of a length that the longest runs, which their
/// values do not choose, give together, so that longer runs have more. Shorter runs are cut one behind the
/// other, what is left of them by less than half a stretch left out. No values where a stretch would be
/// shorter than 10 τ. Approximate, as test_single_run: neighbours are nearly
/// independent.
///
/// memory: τ in rows as the errors themselves tell it (memory_of_squares), by which a stretch is then 7 τ
/// long, and 5 of the τ of ε_k (shortest_stretch).
StretchAverages stretch_averages(std::span<const std::vector<double>> normalised_nees, double memory = kNaN);

/// Averages of groups of 4 (τ − 1) rows, neighbours of which are nearly independent: first of all groups,
/// then of those that begin at each place, of all runs alike: in each tenth of a run, and in its rows 1, 2 to
/// 3, 4 to 7, … What is wrong at one place alone is no matter of tails.
std::vector<SkewedMoments> averages_by_place(std::span<const std::vector<double>> normalised_nees,
                                             double correlation_time);

/// Whether the average of ε_k / n_k over one run is 1.
struct TimeAverageTest {
  MeanInterval average;           ///< from those of the stretches, by student_positive_mean.h
  double p_value = kNaN;          ///< two-sided; NaN without a test, see average.reason
  double effective_steps = kNaN;  ///< independent ones that the run is worth
};

/// Test of the average of ONE run from ε_k / n_k, expected to be 1, over ten equal stretches, whose averages
/// are nearly independent (batch means). No test, with a reason, where a stretch is shorter than 10 τ.
/// The number of stretches is fixed, as one that follows the estimated τ prefers runs that vary little by
/// chance. Approximate: assumes a stationary error that is forgotten (standing_share). Measured on squared
/// autoregressions (φ 0 to 0.95, 300 to 4000 steps, 3,000 studies each): alarms at nominal 5 % in 0.2 to 6.1
/// % of all runs, one without a test none.
TimeAverageTest test_single_run(std::span<const double> normalised_nees, double confidence);

/// The same at several levels, for the cost of one; a stretch must be as long as `memory`, the τ that the
/// errors themselves tell, asks for (shortest_stretch).
std::vector<TimeAverageTest> test_single_run(std::span<const double> normalised_nees,
                                             std::initializer_list<double> confidences, double memory = kNaN);

}  // namespace credence::internal
