#pragma once

#include <Eigen/LU>
#include <cmath>

#include "core/types.h"

namespace credence::internal {

/// The group SE_{1+N}(2) as matrices, its exponential by the series of the matrix: [R, p, l_1 …; 0, I].
class GroupMatrix {
 public:
  static Matrix of(const Vector& x) {
    const Index columns = (x.size() - 1) / 2;
    Matrix X = Matrix::Identity(2 + columns, 2 + columns);
    X.topLeftCorner<2, 2>() << std::cos(x[2]), -std::sin(x[2]), std::sin(x[2]), std::cos(x[2]);
    for (Index i = 0; i < columns; ++i) X.block<2, 1>(0, 2 + i) = x.segment<2>(i == 0 ? 0 : 1 + 2 * i);
    return X;
  }
  static Vector state(const Matrix& X) {
    const Index columns = X.cols() - 2;
    Vector x(1 + 2 * columns);
    x[2] = std::atan2(X(1, 0), X(0, 0));
    for (Index i = 0; i < columns; ++i) x.segment<2>(i == 0 ? 0 : 1 + 2 * i) = X.block<2, 1>(0, 2 + i);
    return x;
  }
  /// Of (ξ_p, φ, ξ_l …).
  static Matrix algebra(const Vector& xi) {
    Matrix A = of(xi);
    A.topLeftCorner<2, 2>() << 0.0, -xi[2], xi[2], 0.0;
    A.bottomRows(A.rows() - 2).setZero();
    return A;
  }
  static Matrix exponential(const Vector& xi) {
    const Matrix A = algebra(xi);
    Matrix sum = Matrix::Identity(A.rows(), A.cols()), term = sum;
    for (int k = 1; k < 40; ++k) sum += term = (term * A / k).eval();
    return sum;
  }
  /// exp(ξ) x.
  static Vector moved(const Vector& x, const Vector& xi) { return state(exponential(xi) * of(x)); }
  /// log(A B⁻¹) of two states near one another, by the series of the logarithm.
  static Vector apart(const Vector& a, const Vector& b) {
    const Matrix A = of(a), B = of(b);
    const Matrix D =
        B.transpose().partialPivLu().solve(A.transpose()).transpose() - Matrix::Identity(A.rows(), A.cols());
    Matrix sum = Matrix::Zero(A.rows(), A.cols()), power = D;
    for (int k = 1; k < 40; ++k) {
      sum += (k % 2 == 1 ? 1.0 : -1.0) / k * power;
      power = (power * D).eval();
    }
    Vector xi(a.size());
    xi[2] = sum(1, 0);
    for (Index i = 0; 2 + i < A.cols(); ++i)
      xi.segment<2>(i == 0 ? 0 : 1 + 2 * i) = sum.block<2, 1>(0, 2 + i);
    return xi;
  }
  /// ξ of A ↦ X A X⁻¹.
  static Matrix adjoint(const Vector& x) {
    const Index n = x.size();
    const Matrix X = of(x), inverse = X.inverse();
    Matrix Ad(n, n);
    for (Index j = 0; j < n; ++j) {
      const Matrix moved = X * algebra(Vector::Unit(n, j)) * inverse;
      Ad(2, j) = moved(1, 0);
      for (Index i = 0; 2 + i < X.cols(); ++i) {
        Ad.block<2, 1>(i == 0 ? 0 : 1 + 2 * i, j) = moved.block<2, 1>(0, 2 + i);
      }
    }
    return Ad;
  }
};

}  // namespace credence::internal
