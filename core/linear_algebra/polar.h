#pragma once

#include <cmath>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"
#include "core/types.h"

/// @file
/// Polar factors of tall, thin matrices: G = V H with orthonormal columns in V and H = (GᵀG)^{1/2} ⪰ 0.
/// No product GᵀG is formed, so small singular values keep their digits. Shared by the inflation bounds.

namespace credence::internal {

/// The orthogonal polar factor of a 2×2 matrix C = [a b; c d]: (C ± cof C)/‖C‖_*, the sign that of det C.
/// Zero for C = 0, when any orthogonal matrix would do.
inline Eigen::Matrix2d orthogonal_factor(const Eigen::Matrix2d& C) {
  const double sign = C(0, 0) * C(1, 1) < C(0, 1) * C(1, 0) ? -1.0 : 1.0;
  double p = C(0, 0) + sign * C(1, 1);
  double q = C(0, 1) - sign * C(1, 0);
  const double nuclear_norm = std::sqrt(p * p + q * q);
  if (nuclear_norm == 0.0) return Eigen::Matrix2d::Zero();
  p /= nuclear_norm;
  q /= nuclear_norm;
  Eigen::Matrix2d U;
  U << p, q, -sign * q, sign * p;
  return U;
}

namespace detail {

/// Orthogonalises v against the first `count` columns of Q, adding what is removed to `along`.
template <typename Column, typename Basis, typename Coefficients>
void remove_components(Column& v, const Basis& Q, Index count, Coefficients&& along) {
  // Repeated until the length no longer drops: one pass of Gram-Schmidt is not enough for nearly dependent
  // columns, and the dual certificate of min_trace relies on orthonormality.
  for (int pass = 0; pass < 4; ++pass) {
    const double before = v.squaredNorm();
    for (Index k = 0; k < count; ++k) {
      const double c = Q.col(k).dot(v);
      v -= c * Q.col(k);
      along(k) += c;
    }
    if (v.squaredNorm() > 0.5 * before) return;
  }
}

}  // namespace detail

/// Thin QR by Gram-Schmidt with reorthogonalisation: G = Q T, Q as tall as G (rows ≥ columns), T upper
/// triangular. Q is orthonormal also where G has no full rank: the missing columns are filled in.
template <typename Derived, int D = Derived::ColsAtCompileTime>
void thin_qr(const Eigen::MatrixBase<Derived>& G, typename Derived::PlainObject& Q,
             Eigen::Matrix<double, D, D>& T) {
  const Index d = G.cols();
  T.setZero(d, d);
  Q.resize(G.rows(), d);
  for (Index j = 0; j < d; ++j) {
    auto v = Q.col(j);
    v = G.col(j);
    detail::remove_components(v, Q, j, T.col(j));
    T(j, j) = v.norm();
    if (T(j, j) > 0.0) {
      v /= T(j, j);
      continue;
    }
    // G.col(j) depends on the columns before it: the axis farthest from their span stands in.
    Index axis = 0;
    Q.leftCols(j).rowwise().squaredNorm().minCoeff(&axis);
    v.setZero();
    v(axis) = 1.0;
    Eigen::Matrix<double, D, 1> unused = Eigen::Matrix<double, D, 1>::Zero(d);
    detail::remove_components(v, Q, j, unused);
    v.normalize();
  }
}

/// The polar factors of G (p×d, p ≥ d): V receives the orthonormal one, H = (GᵀG)^{1/2} is returned, exactly
/// symmetric. For G = 0 any V would do: then V is left as it is.
template <int D, typename DerivedV>
Eigen::Matrix<double, D, D> polar(const Eigen::Matrix<double, Eigen::Dynamic, D>& G,
                                  Eigen::Matrix<double, Eigen::Dynamic, D>& scratch,
                                  Eigen::MatrixBase<DerivedV>&& V) {
  using Square = Eigen::Matrix<double, D, D>;
  const Index d = G.cols();
  Square H = Square::Zero(d, d);
  if constexpr (D == 1) {
    H(0, 0) = G.norm();
    if (H(0, 0) > 0.0) V = G / H(0, 0);
    return H;
  }
  Square T;
  thin_qr(G, scratch, T);
  if (T.isZero(0.0)) return H;
  if constexpr (D == 2) {
    const Eigen::Matrix2d U = orthogonal_factor(T);
    H.noalias() = U.transpose() * T;
    V.noalias() = scratch.lazyProduct(U);
  } else {
    const Eigen::JacobiSVD<Square> svd(T, Eigen::ComputeFullU | Eigen::ComputeFullV);
    H = svd.matrixV() * svd.singularValues().asDiagonal() * svd.matrixV().transpose();
    const Square U = svd.matrixU() * svd.matrixV().transpose();
    V.noalias() = scratch.lazyProduct(U);
  }
  mirror_lower(H);
  return H;
}

}  // namespace credence::internal
