#pragma once

#include "core/manifold/angle.h"
#include "core/manifold/lie_group.h"
#include "core/manifold/rotation.h"

namespace credence {

/// Rotations of the plane, by their angle in (−π, π] rad.
class SO2 : public LieTypes<1> {
 public:
  using Split = SO2;

  SO2() = default;  ///< the identity
  explicit SO2(double angle_rad) : angle_rad_(wrap_angle(angle_rad)) {}

  static SO2 Exp(const Tangent& xi) { return SO2(xi[0]); }
  double angle_rad() const { return angle_rad_; }
  Eigen::Matrix2d matrix() const { return internal::rotation(angle_rad_); }
  Tangent Log() const { return Tangent(angle_rad_); }
  SO2 operator*(const SO2& other) const { return SO2(angle_rad_ + other.angle_rad_); }
  Eigen::Vector2d operator*(const Eigen::Vector2d& v) const { return matrix() * v; }
  SO2 inverse() const { return SO2(-angle_rad_); }
  Jacobian adjoint() const { return Jacobian::Identity(); }
  static Jacobian left_jacobian(const Tangent&) { return Jacobian::Identity(); }
  static Jacobian left_jacobian_inverse(const Tangent&) { return Jacobian::Identity(); }
  Split split() const { return *this; }
  static SO2 join(const Split& split) { return split; }
  Jacobian split_jacobian() const { return Jacobian::Identity(); }

 private:
  double angle_rad_ = 0.0;
};

}  // namespace credence
