#include "analysis/stability/lifted_model.h"

#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {

LinearModel lifted_model(std::span<const LinearModel> period) {
  const LinearModel& first = period.front();
  if (period.size() == 1) return first;
  const Index n = first.state_dim(), m = first.measurement_dim(), q = first.G.cols(), p = std::ssize(period);
  Matrix Phi = Matrix::Identity(n, n), B = Matrix::Zero(n, p * q);
  Matrix O(p * m, n), D(p * m, p * q), Q = Matrix::Zero(p * q, p * q), R = Matrix::Zero(p * m, p * m);
  for (Index k = 0; k < p; ++k) {
    const LinearModel& now = period[static_cast<std::size_t>(k)];
    Phi = (now.F * Phi).eval();
    B = (now.F * B).eval();
    B.middleCols(k * q, q) = now.G;
    O.middleRows(k * m, m) = now.H * Phi;
    D.middleRows(k * m, m) = now.H * B;
    Q.block(k * q, k * q, q, q) = now.Q;
    R.block(k * m, k * m, m, m) = now.R;
  }
  R += D * Q * D.transpose();
  symmetrise(R);
  const Eigen::LLT<Matrix> factor(R);
  if (factor.info() != Eigen::Success) {
    throw std::invalid_argument("the covariance of the measurements of a period is not positive definite");
  }
  const Matrix C = B * Q * D.transpose();
  LinearModel lifted;
  lifted.F = Phi - C * factor.solve(O);
  lifted.G = Matrix::Identity(n, n);
  lifted.Q = B * Q * B.transpose() - C * factor.solve(C.transpose());
  symmetrise(lifted.Q);
  lifted.H = O;
  lifted.R = R;
  lifted.P0 = first.P0;
  lifted.layout = first.layout;
  return lifted;
}

}  // namespace credence::internal
