#include "core/models/landmark_sensor.h"

#include <cmath>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"

namespace credence::internal {

Eigen::Vector2d LandmarkSensor::measure(const Vector2& rho) const {
  if (kind == LandmarkSensorKind::relative_position) return rho;
  return {std::sqrt(rho.squaredNorm()), arc_tangent(rho[1], rho[0])};
}

Eigen::Matrix2d LandmarkSensor::jacobian(const Vector2& rho) const {
  if (kind == LandmarkSensorKind::relative_position) return Eigen::Matrix2d::Identity();
  const double q = rho.squaredNorm(), r = std::sqrt(q);
  Eigen::Matrix2d D;
  D << rho[0] / r, rho[1] / r, -rho[1] / q, rho[0] / q;
  return D;
}

Eigen::Vector2d LandmarkSensor::locate(const Vector2& z) const {
  if (kind == LandmarkSensorKind::relative_position) return z;
  const auto [s, c] = sine_cosine(z[1]);
  return {z[0] * c, z[0] * s};
}

Eigen::Matrix2d LandmarkSensor::inverse_jacobian(const Vector2& z) const {
  if (kind == LandmarkSensorKind::relative_position) return Eigen::Matrix2d::Identity();
  const auto [s, c] = sine_cosine(z[1]);
  Eigen::Matrix2d J;
  J << c, -z[0] * s, s, z[0] * c;
  return J;
}

Eigen::Vector2d LandmarkSensor::innovation(const Vector2& z, const Vector2& predicted) const {
  Vector2 nu = z - predicted;
  if (kind == LandmarkSensorKind::range_bearing) nu[1] = wrap_angle(nu[1]);
  return nu;
}

}  // namespace credence::internal
