#pragma once

#include <Eigen/Geometry>

#include "core/manifold/lie_group.h"
#include "core/manifold/trigonometric_series.h"
#include "core/manifold/trigonometry.h"

namespace credence {

/// φ^ of φ^ v = φ × v.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& phi) {
  Eigen::Matrix3d M;
  M << 0.0, -phi[2], phi[1], phi[2], 0.0, -phi[0], -phi[1], phi[0], 0.0;
  return M;
}

/// Rotations of space, by a unit quaternion; tangent vectors are rotation vectors φ in rad.
class SO3 : public LieTypes<3> {
 public:
  using Split = SO3;

  SO3() = default;                                                            ///< the identity
  explicit SO3(const Eigen::Quaterniond& q) : quaternion_(q.normalized()) {}  ///< q is not 0

  static SO3 Exp(const Tangent& phi) {
    const double angle = phi.norm();
    const internal::SineCosine half = internal::sine_cosine(0.5 * angle);
    Eigen::Quaterniond q;
    q.w() = half.cosine;
    q.vec() = (angle > 0.0 ? half.sine / angle : 0.5) * phi;
    return SO3(q);
  }
  const Eigen::Quaterniond& quaternion() const { return quaternion_; }
  Eigen::Matrix3d matrix() const { return quaternion_.toRotationMatrix(); }
  /// Of the two quaternions of a rotation the one of w ≥ 0, whose angle is at most π.
  Tangent Log() const {
    const double sign = quaternion_.w() < 0.0 ? -1.0 : 1.0;
    const double w = sign * quaternion_.w(), sine = quaternion_.vec().norm();
    return sign * (sine > 0.0 ? 2.0 * internal::arc_tangent(sine, w) / sine : 2.0) * quaternion_.vec();
  }
  SO3 operator*(const SO3& other) const { return SO3(quaternion_ * other.quaternion_); }
  Eigen::Vector3d operator*(const Eigen::Vector3d& v) const { return quaternion_ * v; }
  SO3 inverse() const { return SO3(quaternion_.conjugate()); }
  Jacobian adjoint() const { return matrix(); }

  /// I + s_2 φ^ + s_3 φ^².
  static Jacobian left_jacobian(const Tangent& phi) {
    const internal::TrigonometricSeries s = internal::trigonometric_series(phi.norm());
    return quadratic(phi, s.s2, s.s3);
  }
  /// I − φ^/2 + (1 − (θ/2) cot(θ/2)) / θ² φ^², whose last factor is (s_3 − 2 s_4) / (2 s_2).
  static Jacobian left_jacobian_inverse(const Tangent& phi) {
    const internal::TrigonometricSeries s = internal::trigonometric_series(phi.norm());
    return quadratic(phi, -0.5, (s.s3 - 2.0 * s.s4) / (2.0 * s.s2));
  }

  Split split() const { return *this; }
  static SO3 join(const Split& split) { return split; }
  Jacobian split_jacobian() const { return Jacobian::Identity(); }

 private:
  static Jacobian quadratic(const Tangent& phi, double a, double b) {
    const Eigen::Matrix3d cross = cross_matrix(phi);
    return Jacobian::Identity() + a * cross + b * cross * cross;
  }

  Eigen::Quaterniond quaternion_ = Eigen::Quaterniond::Identity();
};

}  // namespace credence
