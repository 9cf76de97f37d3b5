#pragma once

#include "analysis/laws/correlation/modulation.h"
#include "core/types.h"

/// @file
/// Whether the size of the errors of one run goes up and down in time where σ does not: the covariance is too
/// small at some times and too large at others, and may be right on average.

namespace credence::internal {

/// The p-value of "z_k = e_k/σ_k, one a column, is a stationary series of vectors", by Σ_k |z_k|² e^{−iωk};
/// wave and levels are of |z_k|².
///
/// With Z_λ the Fourier transform of z, N of them, this is E_j = Σ_λ Z_λ* Z_{λ+j}/N at ω = 2πj/N. The phases
/// of the terms of a Gaussian z are independent and uniform given their sizes, whatever the memory of z:
/// |E_j|² over V_j = 2 Σ_λ |Z_λ* Z_{λ+j}|²/N² is no larger than an exponential variable of mean 1 in each
/// moment (docs/theory.md, "The size of a series that has a memory"). For V_j stands the largest of its
/// averages over windows of N, N/2, N/4, N/8, and so on while of 32 values, at most 16 of each, of z as it is
/// and of z brought up to the variance 1 where it is smaller, so that a memory that is longer at some times
/// is none. (As it is: brought up, an offset that slowly walks, as a bias that P claims, has the same size
/// all along.) Where one of the windows of N/8, brought up, has more than 2½ times the average of all, the
/// memory of that stretch decides, and the test is not made. Values are cut at their quantile of 0.9; what
/// heavier tails add to all frequencies is taken off all by the median. The largest of |E_j|²/V_j, and sums
/// of the first 1, 2, 4, 8, 16, Bonferroni over all.
///
/// NaNs where it is not made, of fewer than 130 vectors and of zeros. Cost d N log²N. Measured levels are in
/// docs/statistics.md.
Modulation error_modulation(const MatrixRef& z);

}  // namespace credence::internal
