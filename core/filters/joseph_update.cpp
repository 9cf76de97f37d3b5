#include "core/filters/joseph_update.h"

#include "core/linear_algebra/mirror.h"

namespace credence::internal {

void JosephUpdate::apply(Matrix& P, const MatrixRef& H_of_all, const MatrixRef& K, const MatrixRef& R) {
  states_.clear();
  for (Index i = 0; i < P.cols(); ++i) {
    if (!H_of_all.col(i).isZero(0.0)) states_.push_back(i);
  }
  const Index n = P.rows(), m = K.cols(), c = std::ssize(states_);
  auto H = H_.resize(m, c), P_rows = P_rows_.resize(c, n), K_rows = K_rows_.resize(c, m);
  for (Index i = 0; i < c; ++i) {
    const Index state = states_[static_cast<std::size_t>(i)];
    H.col(i) = H_of_all.col(state);
    P_rows.row(i) = P.row(state);
    K_rows.row(i) = K.row(state);
  }
  auto T = T_.resize(c, c);
  T.setIdentity();
  T.noalias() -= K_rows * H;
  auto KR = KR_.resize(n, m);
  for (Index first = 0; first < m; first += R.cols()) {
    KR.middleCols(first, R.cols()).noalias() = K.middleCols(first, R.cols()) * R;
  }

  // A = T P: in the measured rows by T itself
  auto HP = HP_.resize(m, n), A = A_.resize(n, n), measured_rows = measured_.resize(c, n);
  HP.noalias() = H * P_rows;
  A = P;
  A.noalias() -= K * HP;
  measured_rows.noalias() = T * P_rows;
  for (Index i = 0; i < c; ++i) A.row(states_[static_cast<std::size_t>(i)]) = measured_rows.row(i);

  // A Tᵀ + K R Kᵀ: likewise in the measured columns
  auto A_columns = A_columns_.resize(n, c);
  for (Index i = 0; i < c; ++i) A_columns.col(i) = A.col(states_[static_cast<std::size_t>(i)]);
  auto excess = HP_.resize(n, m);
  excess.noalias() = A_columns * H.transpose();
  excess -= KR;
  P = A;
  P.noalias() -= excess * K.transpose();
  auto measured_columns = measured_.resize(n, c);
  measured_columns.noalias() = A_columns * T.transpose();
  measured_columns.noalias() += KR * K_rows.transpose();
  for (Index i = 0; i < c; ++i) P.col(states_[static_cast<std::size_t>(i)]) = measured_columns.col(i);
  symmetrise(P);
}

}  // namespace credence::internal
