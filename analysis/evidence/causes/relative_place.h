#pragma once

#include "core/types.h"

namespace credence::internal {

/// Where a landmark l lies in the frame of a pose in the plane, r = R(θ)ᵀ (l − p), with its Jacobian.
struct RelativePlace {
  using State = Eigen::Matrix<double, 5, 1>;  ///< p (m), θ (rad), l (m)

  Eigen::Vector2d r;              ///< m
  Eigen::Matrix<double, 2, 5> J;  ///< by the state
};

RelativePlace relative_place(const RelativePlace::State& x);

}  // namespace credence::internal
