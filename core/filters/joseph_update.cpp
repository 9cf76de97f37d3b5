#include "core/filters/joseph_update.h"

#include <vector>

#include "core/linear_algebra/mirror.h"

namespace credence {

void joseph_update(Matrix& P, const MatrixRef& H_of_all, const Matrix& K, const Matrix& R) {
  std::vector<Index> states;  // those that are measured
  for (Index i = 0; i < P.cols(); ++i) {
    if (!H_of_all.col(i).isZero(0.0)) states.push_back(i);
  }
  const Matrix H = H_of_all(Eigen::all, states);
  const auto c = static_cast<Index>(states.size());
  const Matrix T = Matrix::Identity(c, c) - K(states, Eigen::all) * H;
  Matrix KR(K.rows(), K.cols());
  for (Index first = 0; first < K.cols(); first += R.cols()) {
    KR.middleCols(first, R.cols()) = K.middleCols(first, R.cols()) * R;
  }

  // A = T P: in the measured rows by T itself
  Matrix A = P - K * (H * P(states, Eigen::all));
  A(states, Eigen::all) = T * P(states, Eigen::all);
  // A Tᵀ + K R Kᵀ: likewise in the measured columns
  P = A - (A(Eigen::all, states) * H.transpose() - KR) * K.transpose();
  P(Eigen::all, states) = A(Eigen::all, states) * T.transpose() + KR * K(states, Eigen::all).transpose();
  symmetrise(P);
}

}  // namespace credence
