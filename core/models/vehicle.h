#pragma once

#include "core/types.h"

/// @file
/// Planar vehicles: x⁺ = f(x, u), pose x = (x m, y m, θ rad), with their Jacobians (theory, section 2).

namespace credence {

using Pose = Eigen::Vector3d;     ///< [x m; y m; heading rad]
using Control = Eigen::Vector2d;  ///< of its kind: VehicleGeometry

/// The model of its motion.
enum class VehicleKind {
  unicycle,  ///< u = (speed m/s, turn rate rad/s)
  bicycle,   ///< u = (speed m/s, steering rad), both position lines use the old heading
  car,       ///< u = (speed of the rear wheel m/s, steering rad), the pose is that of an offset sensor
};

/// Dimensions of the steered vehicles, in metres; the defaults are the car of the ACFR data set.
struct VehicleGeometry {
  double wheel_base = 2.83;    ///< B of the bicycle, L of the car
  double half_track = 0.76;    ///< H: lateral offset of the wheel that measures the speed (car)
  double sensor_ahead = 3.78;  ///< a: sensor ahead of the rear axle (car)
  double sensor_beside = 0.5;  ///< b: sensor to the left of the axis (car)
};

/// A pose after one step, with F = ∂f/∂x and G = ∂f/∂u at the step's start.
struct Motion {
  Pose pose;
  Eigen::Matrix3d F;
  Eigen::Matrix<double, 3, 2> G;
};

/// How a planar vehicle moves.
struct Vehicle {
  VehicleKind kind = VehicleKind::unicycle;
  VehicleGeometry geometry;

  /// The pose after dt seconds of the constant control u; its heading is wrapped. Jacobians as well.
  ///
  ///   unicycle: x += v dt cos θ, y += v dt sin θ, θ += ω dt
  ///   bicycle:  x += V dt cos(γ+θ), y += V dt sin(γ+θ), θ += V dt sin γ / B
  ///   car:      v_c = v_e / (1 − tan α H/L), x += dt (v_c cos θ − v_c/L tan α (a sin θ + b cos θ)),
  ///             y += dt (v_c sin θ + v_c/L tan α (a cos θ − b sin θ)), θ += dt v_c/L tan α
  Motion move(const Pose& pose, const Control& u, double dt_s) const;

  /// The pose alone.
  Pose moved(const Pose& pose, const Control& u, double dt_s) const;

  /// The control that drives at speed_m_s while turning at turn_rate_rad_s: for the car, the speed of its
  /// rear wheel that gives the axle this speed.
  Control control_for(double speed_m_s, double turn_rate_rad_s) const;
};

}  // namespace credence
