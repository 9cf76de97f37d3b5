#pragma once

#include "core/types.h"

namespace credence::internal {

/// ∂f/∂x by central differences with a fourth-order formula; `f` returns any Eigen vector.
template <class Function>
Matrix numerical_jacobian(const Function& f, const Vector& x, double h = 1e-3) {
  const Index n = x.size();
  Matrix J;
  for (Index j = 0; j < n; ++j) {
    const auto at = [&](double step) {
      Vector moved = x;
      moved[j] += step;
      return Vector(f(moved));
    };
    const Vector column = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
    if (j == 0) J.resize(column.size(), n);
    J.col(j) = column;
  }
  return J;
}

}  // namespace credence::internal
