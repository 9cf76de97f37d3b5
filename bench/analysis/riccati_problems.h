#pragma once

#include <cmath>
#include <random>

#include "analysis/stability/riccati.h"

/// @file
/// The problems that Riccati solvers are timed on.

namespace credence::internal {

inline Matrix random_matrix(Index rows, Index cols, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  Matrix M(rows, cols);
  for (Index i = 0; i < M.size(); ++i) M.data()[i] = normal(generator);
  return M;
}

/// A random stabilisable and detectable system, n/5 outputs and noises, F of spectral radius near 1.
inline RiccatiProblem random_problem(Index n) {
  std::mt19937_64 generator(static_cast<std::uint64_t>(n));
  const Index m = std::max<Index>(1, n / 5);
  const Matrix G = random_matrix(n, m, generator);
  return {random_matrix(n, n, generator) / std::sqrt(static_cast<double>(n)), random_matrix(m, n, generator),
          G * G.transpose(), Matrix::Identity(m, m)};
}

}  // namespace credence::internal
