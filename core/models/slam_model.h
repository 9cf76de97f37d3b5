#pragma once

#include "core/manifold/angle.h"
#include "core/models/range_bearing.h"
#include "core/models/vehicle.h"
#include "core/types.h"

/// @file
/// The models that EkfSlam runs on: dimensions, motion, measurement and its inverse, each with Jacobians.
/// A model of the user's own has the same members.

namespace credence {

/// The planar world: a vehicle and point landmarks seen in range and bearing.
struct PlanarModel {
  static constexpr int kPose = 3, kControl = 2, kLandmark = 2, kMeasurement = 2;

  Vehicle vehicle;
  double dt_s = 0.1;

  Motion move(const Pose& pose, const Control& u) const { return vehicle.move(pose, u, dt_s); }
  static internal::PredictedRangeBearing predict(const Pose& pose, const Point& landmark) {
    return internal::predict_range_bearing(pose, landmark);
  }
  static internal::PlacedLandmark place(const Pose& pose, const RangeBearing& z) {
    return internal::place_landmark(pose, z);
  }
  static RangeBearing innovation(const RangeBearing& z, const RangeBearing& predicted) {
    return internal::range_bearing_innovation(z, predicted);
  }
  static void wrap_pose(Pose& pose) { pose[2] = wrap_angle(pose[2]); }
};

/// The monobot (paper eqs (13)-(15)) in the form that EkfSlam runs on: r⁺ = r + u, z = f − r.
struct MonobotModel {
  static constexpr int kPose = 1, kControl = 1, kLandmark = 1, kMeasurement = 1;
  using Scalar = Eigen::Matrix<double, 1, 1>;
  struct Motion {
    Scalar pose, F = Scalar::Ones(), G = Scalar::Ones();
  };
  struct Prediction {
    Scalar z, H_r = -Scalar::Ones(), H_l = Scalar::Ones();
  };
  struct Placed {
    Scalar position, J_r = Scalar::Ones(), J_z = Scalar::Ones();
  };

  static Motion move(const Scalar& pose, const Scalar& u) { return {.pose = pose + u}; }
  static Prediction predict(const Scalar& pose, const Scalar& landmark) { return {.z = landmark - pose}; }
  static Placed place(const Scalar& pose, const Scalar& z) { return {.position = pose + z}; }
  static Scalar innovation(const Scalar& z, const Scalar& predicted) { return z - predicted; }
  static void wrap_pose(Scalar&) {}
};

}  // namespace credence
