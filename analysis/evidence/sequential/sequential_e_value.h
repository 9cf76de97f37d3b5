#pragma once

#include <span>

#include "analysis/laws/chi_square/chi_square.h"
#include "montecarlo/engine/moments.h"

/// @file
/// Evidence against consistency that may be looked at after every run.
///
/// An e-value is a non-negative statistic with mean at most 1 under consistency. Taken along the runs these
/// are martingales, so by Ville's inequality P(they ever reach 1/α) ≤ α, however often one looks and whenever
/// one stops ([Ville 1939]; [Ramdas 2023]). They depend on a prefix of the runs only by
/// its sums.
///
/// Alternative: the sum of d degrees of freedom is χ²(d)/τ, P being wrong by the factor 1/τ, with τ drawn
/// from Gamma(a, a) around 1; its likelihood ratio has the closed form
///   E_a = a^a Γ(a + d/2) / (Γ(a) (a + S/2)^{a+d/2}) e^{S/2},
/// and the mean over a = 1, 10, 100, 1000, 10⁴ serves deviations from a factor 2 to 1 %. Both directions
/// count.
///
/// Heavy tails alone make ln E, about z²/2, larger by the variance of the values over that of χ²: where they
/// vary more over the runs than the law allows, a logarithm that is positive counts that share of it
/// (share_of_law), and that of a single step the share of this step if it is less. What is at most E keeps
/// the level that E has under χ².

namespace credence::internal {

/// ln of that mean for one sum; 0 for dof 0, infinite for an infinite sum, NaN for a NaN or negative one.
/// Throws std::invalid_argument for a negative or non-finite dof.
double log_e_value(double sum, double dof);

/// Σ 2 m²/d over Σ s² of the steps, of mean m, dof d and variance s² over the runs: the share of their
/// variance that χ² of the same means has; at most 1, and 1 where it cannot be told. Sizes must agree
/// (std::invalid_argument).
double share_of_law(std::span<const Moments> per_step, std::span<const double> total_dof_per_step);

/// A logarithm of an e-value that is positive, times `share`.
inline double discounted(double log_e, double share) { return log_e > 0.0 ? share * log_e : log_e; }

/// ln of the mean over the steps of their e-values: valid for ANY correlation between the steps, as a mean of
/// martingales is one. Steps without data count with e-value 1. Sizes must agree (std::invalid_argument).
double log_e_nees(std::span<const Moments> per_step, std::span<const double> total_dof_per_step);

/// ln of ½ (that mean + the e-value of the sum over steps), valid for white steps; sharper for NIS.
double log_e_nis(std::span<const Moments> per_step, std::span<const double> total_dof_per_step);

/// The factors c for which "the errors are those of the covariance c P at every step" is not refuted: with
/// probability `confidence` it holds the true c for all prefixes of the runs at once (a confidence sequence).
/// [0, ∞) without data; NaN where no common
/// factor fits all steps, or for sums that are not finite.
ChiSquareBounds scale_confidence_sequence(std::span<const Moments> per_step,
                                          std::span<const double> total_dof_per_step, double confidence);

}  // namespace credence::internal
