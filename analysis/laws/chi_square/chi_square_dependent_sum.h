#pragma once

#include <span>

#include "analysis/laws/chi_square/chi_square.h"

/// @file
/// Tests of a sum of chi-squares whose joint law is unknown, such as the NEES summed over the steps of a run.
///
/// If X_k ~ χ²(d_k) with ANY dependence, the quantile of the sum is at most its expected shortfall, and
/// expected shortfall is subadditive, so P(Σ X_k > Σ ES_p(d_k)) ≤ p with ES_p(d) the mean of χ²(d) in its
/// upper tail of probability p; likewise below ([McNeil 2015], section 8.1; [Bernard 2014]).
/// The bound is proved for every dependence and nearly attained by
/// strongly correlated terms: for many dof it asks for 2.34 standard deviations of one term where
/// 1.96 are needed when all terms are equal.

namespace credence::internal {

/// The interval that holds Σ X_k with probability at least `confidence`, half of the rest on each side.
/// Dofs that are not finite and positive, or none, throw std::invalid_argument.
ChiSquareBounds dependent_sum_bounds(std::span<const double> dofs, double confidence);

/// P-values of one direction each.
struct TailPValues {
  double lower = 1.0;  ///< small: the sum is too small
  double upper = 1.0;  ///< small: the sum is too large
};

/// The one-sided p-values of Σ X_k = sum, P(p ≤ α) ≤ α under every dependence; 1 on the other side of the
/// expected value. NaN for a NaN sum; 0 below 1e-300.
TailPValues dependent_sum_tails(double sum, std::span<const double> dofs);

/// A two-sided p-value of Σ X_k = sum, P(p ≤ α) ≤ α under every dependence; 1 at the expected value.
/// NaN for a NaN sum; 0 below 1e-300.
double dependent_sum_p_value(double sum, std::span<const double> dofs);

}  // namespace credence::internal
