#include "analysis/stability/riccati_scaling.h"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_product.h"

namespace credence::internal {
namespace {

constexpr int kMaxSweeps = 20;
constexpr double kLargestExponent = 120.0;
constexpr double kBalanced = 1.5;  // what rounds to less than 2

/// What drives state i and what it drives: couplings to others, which its scale changes by a factor, and its
/// own entries, which it changes by the square of that.
struct Balance {
  double row = 0.0, row_own = 0.0, column = 0.0, column_own = 0.0;

  /// log2 of their ratio once the state is scaled by 2^e; falls with e.
  double after(double e) const {
    return std::log2(row * std::exp2(-e) + row_own * std::exp2(-2.0 * e)) -
           std::log2(column * std::exp2(e) + column_own * std::exp2(2.0 * e));
  }
};

Balance balance_of(const Matrix& F, const Matrix& Q, const Matrix& Gamma, Index i) {
  Balance balance;
  balance.row_own = std::abs(Q(i, i));
  balance.column_own = std::abs(Gamma(i, i));
  balance.row = F.row(i).lpNorm<1>() - std::abs(F(i, i)) + Q.col(i).lpNorm<1>() - balance.row_own;
  balance.column = F.col(i).lpNorm<1>() - std::abs(F(i, i)) + Gamma.col(i).lpNorm<1>() - balance.column_own;
  return balance;
}

/// The exponent that balances: its ratio falls by 2 to 4 a unit, so a quarter of it never goes too far.
double wanted_exponent(const Balance& balance) {
  if (balance.after(-kBalanced) > 0.0 && balance.after(kBalanced) < 0.0) return 0.0;
  double e = 0.0, step = 1.0;
  for (int i = 0; i < 20 && std::abs(step) > 0.01; ++i) e += step = 0.25 * balance.after(e);
  return std::round(e);
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
      if (!(balance.row + balance.row_own > 0.0 && balance.column + balance.column_own > 0.0)) continue;
      const double wanted = wanted_exponent(balance);
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
  Matrix information;
  MatrixProduct().set(information, ProductFactor::transposed(H), H);
  scaled.d = balancing_scales(problem.F, driving_noise(problem.Qt, P0), information);
  const Vector inverse = scaled.d.cwiseInverse();
  scaled.problem.F = inverse.asDiagonal() * problem.F * scaled.d.asDiagonal();
  scaled.problem.H = (H * scaled.d.asDiagonal()).eval();
  scaled.problem.Qt = inverse.asDiagonal() * problem.Qt * inverse.asDiagonal();
  scaled.P0 = inverse.asDiagonal() * P0 * inverse.asDiagonal();
  return scaled;
}

}  // namespace credence::internal
