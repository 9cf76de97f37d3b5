#pragma once

#include "core/types.h"

/// @file
/// The extreme eigenvalues of W/M, W ~ Wishart_n(M, I): of the sample covariance of M vectors N(0, I_n) about
/// zero.
///
/// I. M. Johnstone, "On the distribution of the largest eigenvalue in principal components analysis", Ann.
/// Stat. 29 (2001), and for the smallest Z. Ma, "Accuracy of the Tracy-Widom limits for the extreme
/// eigenvalues in white Wishart matrices", Bernoulli 18 (2012): with a = √(M − ½), b = √(n − ½),
///
///   (λ_max M − (a + b)²) / ((a + b) (1/a + 1/b)^{1/3}) ≈ TW₁,
///   (ln(λ_min M) − ν)/τ ≈ −TW₁,  τ = (1/b − 1/a)^{1/3}/(a − b),  ν = 2 ln(a − b) + τ²/8,
///
/// and TW₁ as the shifted gamma law of M. Chiani, "Distribution of the largest eigenvalue for real Wishart
/// and Gaussian random matrices and a simple approximation for the Tracy-Widom distribution", J. Multivar.
/// Anal. 129 (2014). One dimension is exact, χ²(M)/M. Measured at 2.5 % a side for n = 2 … 30, M = n + 2 …
/// 200 n: 1.6 to 3.1 %.

namespace credence::internal {

/// P(λ_max ≥ x). Throws std::invalid_argument unless n ≥ 1 and M > n; NaN for a NaN x. So do all below.
double largest_root_p_value(double x, double runs, Index n);

/// P(λ_min ≤ x).
double smallest_root_p_value(double x, double runs, Index n);

/// The x with P(λ_max ≥ x) = probability, in (0, 1).
double largest_root_quantile(double probability, double runs, Index n);

/// The x with P(λ_min ≤ x) = probability, in (0, 1).
double smallest_root_quantile(double probability, double runs, Index n);

}  // namespace credence::internal
