#pragma once

#include "core/models/vehicle.h"
#include "core/types.h"

/// @file
/// The range-bearing sensor of the planar world: z = h(x, l) = (|l − p|, atan2(l − p) − θ), in m and rad.

namespace credence {

using Point = Eigen::Vector2d;         ///< [x; y], m
using RangeBearing = Eigen::Vector2d;  ///< [range m; bearing rad]

}  // namespace credence

namespace credence::internal {

/// A predicted measurement with H_r = ∂h/∂x and H_l = ∂h/∂l.
struct PredictedRangeBearing {
  RangeBearing z;  ///< bearing in (−π, π]
  Eigen::Matrix<double, 2, 3> H_r;
  Eigen::Matrix2d H_l;
};

/// h and its Jacobians. Not finite where the landmark coincides with the vehicle.
PredictedRangeBearing predict_range_bearing(const Pose& pose, const Point& landmark);

/// h alone.
RangeBearing measure_range_bearing(const Pose& pose, const Point& landmark);

/// A landmark placed by a measurement, g(x, z), with J_r = ∂g/∂x and J_z = ∂g/∂z.
struct PlacedLandmark {
  Point position;
  Eigen::Matrix<double, 2, 3> J_r;
  Eigen::Matrix2d J_z;
};

/// The inverse sensor model: where a landmark that is seen at z from `pose` is.
PlacedLandmark place_landmark(const Pose& pose, const RangeBearing& z);

/// z − z_predicted with the bearing wrapped.
RangeBearing range_bearing_innovation(const RangeBearing& z, const RangeBearing& predicted);

}  // namespace credence::internal
