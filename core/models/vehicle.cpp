#include "core/models/vehicle.h"

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"

namespace credence::internal {
namespace {

Motion move_unicycle(const Pose& pose, const Control& u, double dt) {
  const auto [s, c] = sine_cosine(pose[2]);
  Motion m;
  m.pose << pose[0] + u[0] * dt * c, pose[1] + u[0] * dt * s, wrap_angle(pose[2] + u[1] * dt);
  m.F << 1, 0, -u[0] * dt * s, 0, 1, u[0] * dt * c, 0, 0, 1;
  m.G << dt * c, 0, dt * s, 0, 0, dt;
  return m;
}

Motion move_bicycle(const Pose& pose, const Control& u, double dt, double wheel_base) {
  const double V = u[0], gamma = u[1];
  const auto [s, c] = sine_cosine(gamma + pose[2]);
  const auto [sg, cg] = sine_cosine(gamma);
  Motion m;
  m.pose << pose[0] + V * dt * c, pose[1] + V * dt * s, wrap_angle(pose[2] + V * dt * sg / wheel_base);
  m.F << 1, 0, -V * dt * s, 0, 1, V * dt * c, 0, 0, 1;
  m.G << dt * c, -V * dt * s, dt * s, V * dt * c, dt * sg / wheel_base, V * dt * cg / wheel_base;
  return m;
}

Motion move_car(const Pose& pose, const Control& u, double dt, const VehicleGeometry& g) {
  const double L = g.wheel_base, a = g.sensor_ahead, b = g.sensor_beside;
  const SineCosine steering = sine_cosine(u[1]);
  const double t = steering.sine / steering.cosine;
  const double denominator = 1.0 - t * g.half_track / L;
  const double vc = u[0] / denominator;
  const auto [s, c] = sine_cosine(pose[2]);
  // Direction in which the sensor moves per unit of v_c, and its derivative with respect to tan α.
  const double dx_dt = -(a * s + b * c) / L, dy_dt = (a * c - b * s) / L;
  const double ex = c + t * dx_dt, ey = s + t * dy_dt;
  const double dvc_dt = vc * (g.half_track / L) / denominator;
  const double dt_dalpha = 1.0 + t * t;

  Motion m;
  m.pose << pose[0] + dt * vc * ex, pose[1] + dt * vc * ey, wrap_angle(pose[2] + dt * vc * t / L);
  m.F << 1, 0, -dt * vc * ey, 0, 1, dt * vc * ex, 0, 0, 1;
  m.G.col(0) << dt * ex / denominator, dt * ey / denominator, dt * t / L / denominator;
  m.G.col(1) << dt * (dvc_dt * ex + vc * dx_dt), dt * (dvc_dt * ey + vc * dy_dt), dt * (dvc_dt * t + vc) / L;
  m.G.col(1) *= dt_dalpha;
  return m;
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

Motion Vehicle::move(const Pose& pose, const Control& u, double dt_s) const {
  switch (kind) {
    case VehicleKind::bicycle: return move_bicycle(pose, u, dt_s, geometry.wheel_base);
    case VehicleKind::car: return move_car(pose, u, dt_s, geometry);
    case VehicleKind::unicycle: break;
  }
  return move_unicycle(pose, u, dt_s);
}

Pose Vehicle::moved(const Pose& pose, const Control& u, double dt_s) const {
  return move(pose, u, dt_s).pose;
}

Control Vehicle::control_for(double speed_m_s, double turn_rate_rad_s) const {
  switch (kind) {
    case VehicleKind::bicycle:
      return {speed_m_s, arc_sine(turn_rate_rad_s * geometry.wheel_base / speed_m_s)};
    case VehicleKind::car: {
      const double tangent = turn_rate_rad_s * geometry.wheel_base / speed_m_s;
      return {speed_m_s * (1.0 - tangent * geometry.half_track / geometry.wheel_base),
              arc_tangent(tangent, 1.0)};
    }
    case VehicleKind::unicycle: break;
  }
  return {speed_m_s, turn_rate_rad_s};
}

}  // namespace credence
