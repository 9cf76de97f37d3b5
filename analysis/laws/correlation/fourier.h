#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace credence::internal {

/// The largest product of 2, 3 and 5 that is no larger than n ≥ 1: what is transformed quickly.
std::size_t quick_length(std::size_t n);

/// Σ_k u_k e^{−iωk} at ω = 2πj/N, 0 ≤ j < N.
std::vector<std::complex<double>> fourier(std::span<const double> u);

/// Its squared size at 0 < j < N/2.
std::vector<double> periodogram(std::span<const double> u);

}  // namespace credence::internal
