#pragma once

#include "core/types.h"

namespace credence::internal {

/// Where a landmark l lies in the frame of a pose in the plane, r = R(θ)ᵀ (l − p).
struct RelativePlace {
  using State = Eigen::Matrix<double, 5, 1>;  ///< p (m), θ (rad), l (m)
  using Covariance = Eigen::Matrix<double, 5, 5>;

  explicit RelativePlace(const State& x);
  /// With sin θ and cos θ, as they are known.
  RelativePlace(const State& x, double sine, double cosine);

  /// ∂r/∂x.
  Eigen::Matrix<double, 2, 5> jacobian() const;
  /// Of r, of that of the state.
  Eigen::Matrix2d covariance(const Covariance& P) const;

  double sine = 0.0, cosine = 1.0;  ///< of θ
  Eigen::Vector2d r;                ///< m
};

}  // namespace credence::internal
