#pragma once

#include "core/manifold/product_group.h"
#include "core/manifold/so3.h"
#include "core/manifold/vector_group.h"

namespace credence {

/// SE_k(3): a rotation R and k vectors t_1 … t_k that turn with it, (R, t)(R', t') = (R R', R t' + t)
/// ([Barrau 2017]). SE(3) is a pose, SE_2(3) position, velocity and attitude. Tangent vectors
/// are (ρ_1, …, ρ_k, φ).
template <int k>
class SEk3 : public LieTypes<3 * k + 3> {
  using Types = LieTypes<3 * k + 3>;

 public:
  using typename Types::Jacobian;
  using typename Types::Tangent;
  using Vectors = Eigen::Matrix<double, 3, k>;  ///< a column for each vector
  using Split = ProductGroup<VectorGroup<3 * k>, SO3>;

  SEk3() = default;  ///< the identity
  SEk3(const SO3& rotation, const Vectors& vectors) : rotation_(rotation), vectors_(vectors) {}

  const SO3& rotation() const { return rotation_; }
  const Vectors& vectors() const { return vectors_; }
  Eigen::Vector3d translation() const { return vectors_.col(0); }
  Eigen::Vector3d velocity() const requires(k > 1) { return vectors_.col(1); }

  static SEk3 Exp(const Tangent& xi) {
    const Eigen::Vector3d phi = angle_of(xi);
    return {SO3::Exp(phi), SO3::left_jacobian(phi) * vectors_of(xi)};
  }
  Tangent Log() const {
    const Eigen::Vector3d phi = rotation_.Log();
    return tangent(SO3::left_jacobian_inverse(phi) * vectors_, phi);
  }
  SEk3 operator*(const SEk3& other) const {
    return {rotation_ * other.rotation_, rotation_.matrix() * other.vectors_ + vectors_};
  }
  SEk3 inverse() const {
    const SO3 back = rotation_.inverse();
    return {back, -(back.matrix() * vectors_)};
  }
  Jacobian adjoint() const {
    const Eigen::Matrix3d R = rotation_.matrix();
    Jacobian Ad = repeated(R);
    for (int i = 0; i < k; ++i) last_column(Ad, i) = cross_matrix(vectors_.col(i)) * R;
    return Ad;
  }

  /// J of SO(3) on the diagonal, Q(ρ_i, φ) in the last column ([Barfoot 2017], equation 7.86).
  static Jacobian left_jacobian(const Tangent& xi) {
    const Eigen::Vector3d phi = angle_of(xi);
    Jacobian J = repeated(SO3::left_jacobian(phi));
    for (int i = 0; i < k; ++i) last_column(J, i) = coupling(vectors_of(xi).col(i), phi);
    return J;
  }
  static Jacobian left_jacobian_inverse(const Tangent& xi) {
    const Eigen::Vector3d phi = angle_of(xi);
    const Eigen::Matrix3d inverse = SO3::left_jacobian_inverse(phi);
    Jacobian J = repeated(inverse);
    for (int i = 0; i < k; ++i) {
      last_column(J, i) = -inverse * coupling(vectors_of(xi).col(i), phi) * inverse;
    }
    return J;
  }

  Split split() const {
    return {VectorGroup<3 * k>(Eigen::Map<const Eigen::Matrix<double, 3 * k, 1>>(vectors_.data())),
            rotation_};
  }
  static SEk3 join(const Split& split) {
    return {split.second(), Eigen::Map<const Vectors>(split.first().vector().data())};
  }
  Jacobian split_jacobian() const {
    Jacobian D = repeated(rotation_.matrix());
    D.template bottomRightCorner<3, 3>().setIdentity();
    return D;
  }

 private:
  static Eigen::Vector3d angle_of(const Tangent& xi) { return xi.template tail<3>(); }
  static Vectors vectors_of(const Tangent& xi) { return Eigen::Map<const Vectors>(xi.data()); }
  static Tangent tangent(const Vectors& rho, const Eigen::Vector3d& phi) {
    Tangent xi;
    xi << Eigen::Map<const Eigen::Matrix<double, 3 * k, 1>>(rho.data()), phi;
    return xi;
  }
  /// Block diagonal, the same k + 1 times.
  static Jacobian repeated(const Eigen::Matrix3d& block) {
    Jacobian M = Jacobian::Zero();
    for (int i = 0; i <= k; ++i) M.template block<3, 3>(3 * i, 3 * i) = block;
    return M;
  }
  static auto last_column(Jacobian& M, int i) { return M.template block<3, 3>(3 * i, 3 * k); }

  /// ρ^/2 + s_3 (φ^ρ^ + ρ^φ^ + φ^ρ^φ^) + s_4 (φ^φ^ρ^ + ρ^φ^φ^ − 3 φ^ρ^φ^)
  ///      + (s_4 − 3 s_5)/2 (φ^ρ^φ^φ^ + φ^φ^ρ^φ^).
  static Eigen::Matrix3d coupling(const Eigen::Vector3d& rho, const Eigen::Vector3d& phi) {
    const internal::TrigonometricSeries s = internal::trigonometric_series(phi.norm());
    const Eigen::Matrix3d p = cross_matrix(phi), r = cross_matrix(rho);
    const Eigen::Matrix3d pr = p * r, prp = pr * p;
    return 0.5 * r + s.s3 * (pr + r * p + prp) + s.s4 * (p * pr + r * p * p - 3.0 * prp) +
           0.5 * (s.s4 - 3.0 * s.s5) * (prp * p + p * prp);
  }

  SO3 rotation_;
  Vectors vectors_ = Vectors::Zero();
};

using SE3 = SEk3<1>;   ///< position, attitude
using SE23 = SEk3<2>;  ///< position, velocity, attitude

}  // namespace credence
