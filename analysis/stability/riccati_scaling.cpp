#include "analysis/stability/riccati_scaling.h"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra/cholesky.h"

namespace credence {
namespace {

constexpr int kMaxSweeps = 20;
constexpr double kLargestExponent = 120.0;

/// Size of what drives state i (falls with d_i) and of what it drives (grows with d_i).
struct Balance {
  double row = 0.0, column = 0.0;
};

Balance balance_of(const Matrix& F, const Matrix& Q, const Matrix& Gamma, Index i) {
  Balance balance;
  balance.row = F.row(i).lpNorm<1>() - std::abs(F(i, i)) + Q.col(i).lpNorm<1>();
  balance.column = F.col(i).lpNorm<1>() - std::abs(F(i, i)) + Gamma.col(i).lpNorm<1>();
  return balance;
}

void rescale(Matrix& F, Matrix& Q, Matrix& Gamma, Index i, double factor) {
  F.row(i) /= factor;
  F.col(i) *= factor;
  Q.row(i) /= factor;
  Q.col(i) /= factor;
  Gamma.row(i) *= factor;
  Gamma.col(i) *= factor;
}

/// A state that nothing drives is sized by its initial variance.
Matrix driving_noise(const Matrix& Qt, MatrixRef P0) {
  Matrix Q = Qt;
  for (Index i = 0; i < Q.rows(); ++i) {
    if (Q(i, i) == 0.0) Q(i, i) = P0(i, i);
  }
  return Q;
}

Vector balancing_scales(Matrix F, Matrix Q, Matrix Gamma) {
  const Index n = F.rows();
  Vector exponents = Vector::Zero(n);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool changed = false;
    for (Index i = 0; i < n; ++i) {
      const Balance balance = balance_of(F, Q, Gamma, i);
      if (!(balance.row > 0.0 && balance.column > 0.0)) continue;
      const double wanted = std::round(0.5 * std::log2(balance.row / balance.column));
      const double step =
          std::clamp(exponents[i] + wanted, -kLargestExponent, kLargestExponent) - exponents[i];
      if (std::abs(step) < 2.0) continue;  // within a factor of four is balanced
      exponents[i] += step;
      rescale(F, Q, Gamma, i, std::exp2(step));
      changed = true;
    }
    if (!changed) break;
  }
  return exponents.unaryExpr([](double e) { return std::exp2(e); });
}

}  // namespace

ScaledRiccati scale_riccati(const RiccatiProblem& problem, MatrixRef P0) {
  const Index m = problem.H.rows();
  ScaledRiccati scaled;
  scaled.problem = problem;
  if (m > 0) {
    const Eigen::LLT<Matrix> llt(problem.R);
    scaled.problem.H = llt.matrixL().solve(problem.H);
    scaled.problem.R = Matrix::Identity(m, m);
  }
  const Matrix& H = scaled.problem.H;
  scaled.d = balancing_scales(problem.F, driving_noise(problem.Qt, P0), H.transpose() * H);
  const Vector inverse = scaled.d.cwiseInverse();
  scaled.problem.F = inverse.asDiagonal() * problem.F * scaled.d.asDiagonal();
  scaled.problem.H = (H * scaled.d.asDiagonal()).eval();
  scaled.problem.Qt = inverse.asDiagonal() * problem.Qt * inverse.asDiagonal();
  scaled.P0 = inverse.asDiagonal() * P0 * inverse.asDiagonal();
  return scaled;
}

}  // namespace credence
