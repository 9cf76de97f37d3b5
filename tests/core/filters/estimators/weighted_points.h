#pragma once

#include <cmath>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// Mean and covariance by the 2l + 1 weighted points of [Julier 2004] with κ = 0 and β = 2.
struct WeightedPoints {
  Vector mean;
  Matrix covariance, cross;

  template <class Function>
  WeightedPoints(Function f, const Vector& x, const Matrix& L, double alpha) {
    const auto l = static_cast<double>(x.size());
    const double lambda = alpha * alpha * l - l;
    std::vector<Vector> points{x};
    for (Index j = 0; j < x.size(); ++j) {
      points.emplace_back(x + std::sqrt(l + lambda) * L.col(j));
      points.emplace_back(x - std::sqrt(l + lambda) * L.col(j));
    }
    const auto weight = [&](std::size_t i) { return i == 0 ? lambda / (l + lambda) : 0.5 / (l + lambda); };
    mean = Vector::Zero(f(x).size());
    for (std::size_t i = 0; i < points.size(); ++i) mean += weight(i) * f(points[i]);
    covariance = Matrix::Zero(mean.size(), mean.size());
    cross = Matrix::Zero(x.size(), mean.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double w = weight(i) + (i == 0 ? 1.0 - alpha * alpha + 2.0 : 0.0);
      const Vector d = f(points[i]) - mean;
      covariance += w * d * d.transpose();
      cross += w * (points[i] - x) * d.transpose();
    }
  }
};

}  // namespace credence::internal
