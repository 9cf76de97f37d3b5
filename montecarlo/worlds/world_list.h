#pragma once

#include "montecarlo/worlds/world.h"

/// @file
/// Every world; each is stated in a folder of its own.

namespace credence::internal {

/// A vehicle on a line that sees every landmark (theory, section 2): linear.
extern const World kMonobotWorld;
/// A vehicle in the plane that measures range and bearing of landmarks: EKF-SLAM.
extern const World kPlanarWorld;
/// Any linear time-invariant system, its matrices written in the scenario, and a filter that may believe in
/// others (LinearModel, core/models/linear_model.h).
extern const World kLinearWorld;
/// A target of nearly constant velocity in one to three dimensions, whose position, or range and bearing, are
/// measured ([Bar-Shalom 2001], section 6.2).
extern const World kTrackingWorld;
/// A vehicle that drives a circle and reads its odometry, for any of the estimators of
/// core/filters/estimators.
extern const World kPlanarSlamWorld;
/// A vehicle in the plane that knows its map, or is told its position, and may not know where it looks at the
/// start ([Barrau 2017], section IV).
extern const World kLocalisationWorld;
/// A vehicle with a strapdown inertial unit and its biases, aided by satellites or landmarks at a lower rate
/// ([Barrau 2017], section V).
extern const World kInertialWorld;
/// A pendulum that white noise drives, of which the horizontal displacement is measured: the textbook example
/// of the extended and the unscented Kalman filter.
extern const World kPendulumWorld;
/// A vehicle that flies a closed path in space and reads its odometry, for any of the estimators of
/// core/filters/spatial.
extern const World kSpatialSlamWorld;

}  // namespace credence::internal
