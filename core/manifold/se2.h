#pragma once

#include "core/manifold/product_group.h"
#include "core/manifold/so2.h"
#include "core/manifold/trigonometric_series.h"
#include "core/manifold/vector_group.h"

namespace credence {

/// Rigid motions of the plane, p ↦ R p + t; tangent vectors are (ρ m, θ rad).
class SE2 : public LieTypes<3> {
 public:
  using Split = ProductGroup<VectorGroup<2>, SO2>;

  SE2() = default;  ///< the identity
  SE2(const SO2& rotation, const Eigen::Vector2d& translation)
      : rotation_(rotation), translation_(translation) {}

  const SO2& rotation() const { return rotation_; }
  const Eigen::Vector2d& translation() const { return translation_; }

  static SE2 Exp(const Tangent& xi) {
    return {SO2(xi[2]), internal::exponential_factor(xi[2]) * xi.head<2>()};
  }
  Tangent Log() const {
    Tangent xi;
    xi << internal::logarithm_factor(rotation_.angle_rad()) * translation_, rotation_.angle_rad();
    return xi;
  }
  SE2 operator*(const SE2& other) const {
    return {rotation_ * other.rotation_, rotation_ * other.translation_ + translation_};
  }
  SE2 inverse() const {
    const SO2 back = rotation_.inverse();
    return {back, -(back * translation_)};
  }
  Jacobian adjoint() const { return joined(rotation_.matrix(), -internal::quarter_turn(translation_)); }

  /// [V, −W J ρ; 0, 1] with V = s_1 I + θ s_2 J, W = s_2 I + θ s_3 J.
  static Jacobian left_jacobian(const Tangent& xi) {
    return joined(internal::exponential_factor(xi[2]), rotation_column(xi));
  }
  static Jacobian left_jacobian_inverse(const Tangent& xi) {
    const Eigen::Matrix2d V_inverse = internal::logarithm_factor(xi[2]);
    return joined(V_inverse, -(V_inverse * rotation_column(xi)));
  }

  Split split() const { return {VectorGroup<2>(translation_), rotation_}; }
  static SE2 join(const Split& split) { return {split.second(), split.first().vector()}; }
  Jacobian split_jacobian() const { return joined(rotation_.matrix(), Eigen::Vector2d::Zero()); }

 private:
  static Eigen::Vector2d rotation_column(const Tangent& xi) {
    const internal::TrigonometricSeries s = internal::trigonometric_series(xi[2]);
    const Eigen::Vector2d turned = internal::quarter_turn(xi.head<2>());
    return -(s.s2 * turned + xi[2] * s.s3 * internal::quarter_turn(turned));
  }
  static Jacobian joined(const Eigen::Matrix2d& A, const Eigen::Vector2d& b) {
    Jacobian M;
    M << A, b, 0.0, 0.0, 1.0;
    return M;
  }

  SO2 rotation_;
  Eigen::Vector2d translation_ = Eigen::Vector2d::Zero();
};

}  // namespace credence
