#pragma once

#include <span>

#include "core/types.h"

namespace credence::internal {

/// The error and covariance of the states `places` alone, of an error of n and a P of n×n; keeps their
/// memory.
inline void take_block(const VectorRef& error, const MatrixRef& P, std::span<const Index> places,
                       Vector& block_error, Matrix& block_P) {
  const Index n = std::ssize(places);
  if (block_error.size() != n) block_error.resize(n);
  if (block_P.rows() != n) block_P.resize(n, n);
  for (Index j = 0; j < n; ++j) {
    const Index from = places[static_cast<std::size_t>(j)];
    block_error[j] = error[from];
    for (Index i = 0; i < n; ++i) block_P(i, j) = P(places[static_cast<std::size_t>(i)], from);
  }
}

}  // namespace credence::internal
