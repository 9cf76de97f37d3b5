#pragma once

#include <cmath>
#include <random>

#include "core/linear_algebra/decompositions.h"
#include "core/types.h"

namespace credence::internal {

/// n×n of full rank, its variances over six decades, with an error of the same size.
struct JudgedError {
  Matrix P;
  Vector e;

  explicit JudgedError(Index n, unsigned seed = 1) : P(n, n), e(n) {
    std::mt19937_64 bits(seed);
    std::normal_distribution<double> normal;
    Matrix A(n, n + 2);
    for (double& a : A.reshaped()) a = normal(bits);
    const Vector scale =
        Vector::LinSpaced(n, -3.0, 3.0).unaryExpr([](double x) { return std::pow(10.0, x); });
    P = scale.asDiagonal() * A * A.transpose() * scale.asDiagonal();
    for (double& x : e) x = normal(bits);
    e = e.cwiseProduct(scale).eval();
  }
};

/// P⁻¹ by a decomposition that is no Cholesky factor, of P scaled to unit diagonal.
inline Matrix inverse_by_lu(const Matrix& P) {
  const Vector scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix C = scale.asDiagonal() * P * scale.asDiagonal();
  return scale.asDiagonal() * Eigen::FullPivLU<Matrix>(C).inverse() * scale.asDiagonal();
}

inline double square_by_lu(const Vector& e, const Matrix& P) { return e.dot(inverse_by_lu(P) * e); }

}  // namespace credence::internal
