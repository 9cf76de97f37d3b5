#pragma once

#include <cstdint>
#include <span>

#include "analysis/laws/mean/student.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// The sharp test of NEES or NIS: whole runs are the units.
///
/// X_i = Σ_k ε_ik / Σ_k n_ik is the average of run i, of all its steps or of those of a window, block or
/// sensor. Under consistency the X_i are independent over the runs and E X_i = 1, whatever the dependence in
/// time and whatever each run saw, as long as the dofs n_ik do not depend on the errors. Their law is
/// unknown: for Gaussian errors X = Σ_j λ_j χ²₁ with λ_j ≥ 0, Σ λ_j = 1, which may be nearly normal (many
/// independent steps) or as skewed as χ²₁ (one constant error), or one skewed part upon a constant. Two
/// scores remove the skewness in different ways, the cube root of a gamma law (student_positive_mean.h) and
/// that of Hall (hall_score.h), and a direction is rejected only where both, against t(M − 1), reject it.
///
/// On the pessimistic side the large values may be missing, and with them the skewness γ of the sample:
/// Hall's score takes max(γ, min(√8, γ + (20 γ + 8)/M)) there, √8 being the largest skewness of any
/// Σ_j λ_j χ²₁, and the p-value is the larger of that of t(M − 1) and half that of t((M − 1)/3), which holds
/// far out.
///
/// With fewer than 20 runs both errors are too large on the pessimistic side. There a bound that is proved
/// for every dependence is used: as an average of variables χ²(n_k)/n_k, X is at most χ²(n)/n in convex
/// order, n the least n_k, and so is x̄ with M n, so that P(x̄ ≤ μ E[Y | Y ≤ q_p]) ≤ p, Y = χ²(M n)/(M n), q_p
/// its p-quantile (expected shortfall; chi_square_dependent_sum.h). It needs Gaussian errors. The optimistic
/// side takes the cube root alone. A single run has the bound on both sides.
///
/// Levels: for 20 runs and more asymptotically exact whatever the law, by the central limit theorem with the
/// skewness removed; the numbers above are of simulations, whose levels are in docs/statistics.md.

namespace credence::internal {

/// Fewer runs than these are judged by the bound for every dependence, which loses little there.
inline constexpr std::int64_t kFewestRunsCompared = 5;

/// P-values of the two one-sided hypotheses.
struct DirectedPValues {
  double optimistic = 1.0;   ///< small: the mean is too large, P too small
  double pessimistic = 1.0;  ///< small: the mean is too small, P too large

  double two_sided() const;  ///< min(1, 2 min of both); NaN if they are
};

/// The p-values of E X = expected. least_dof: the smallest dof n_k of any step of any run; 1 holds always and
/// is the weakest. NaN for no runs, or a mean that is not finite or negative; runs that are all equal decide
/// by their mean, unless it is as expected to 1e-6. Throws std::invalid_argument unless expected > 0 and
/// least_dof > 0 are finite.
DirectedPValues run_mean_p_values(const SkewedMoments& run_averages, double expected, double least_dof = 1.0);

/// The least two-sided p-value of E X = expected of several averages, NaN left out, and how many there are.
/// Those of fewer than `fewest` runs are left out, too. Of averages over as many runs each, as of the steps
/// of a study, few p-values are computed: those of scores that are further out than all before.
struct LeastPValue {
  double p_value = 1.0;
  std::int64_t tests = 0;
};
LeastPValue least_run_mean_p_value(std::span<const SkewedMoments> averages, double expected,
                                   std::int64_t fewest);

/// The interval of all means that neither direction rejects at (1 − confidence)/2: as E X is the factor
/// between the true and the claimed covariance where that is the same for all steps, the interval of the
/// factor on P. Its upper end is infinite when no mean is too large. Reason where there is none. Throws as
/// run_mean_p_values, and unless 0 < confidence < 1.
MeanInterval run_mean_interval(const SkewedMoments& run_averages, double confidence, double least_dof = 1.0);

}  // namespace credence::internal
