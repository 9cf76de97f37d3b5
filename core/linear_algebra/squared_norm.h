#pragma once

#include <vector>

#include "core/types.h"

namespace credence::internal {

/// Σ v_i² over these places. A plain loop: GCC 12 warns of what it makes of an indexed view.
inline double squared_norm(const Vector& values, const std::vector<Index>& places) {
  double sum = 0.0;
  for (const Index i : places) sum += values[i] * values[i];
  return sum;
}

}  // namespace credence::internal
