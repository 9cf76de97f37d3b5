#pragma once

#include <cstdint>
#include <random>

#include "core/types.h"

namespace credence::internal {

/// Independent standard normals.
inline Matrix random_matrix(Index rows, Index columns, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Matrix M(rows, columns);
  for (double& x : M.reshaped()) x = normal(generator);
  return M;
}

}  // namespace credence::internal
