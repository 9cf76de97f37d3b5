#pragma once

#include <vector>

#include "analysis/laws/shape/vector_moments.h"

namespace credence::internal::testing {

inline VectorMoments moments_of(const std::vector<Vector>& values) {
  VectorMoments moments;
  for (const Vector& u : values) moments.add(u);
  return moments;
}

}  // namespace credence::internal::testing
