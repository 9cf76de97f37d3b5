#include "core/filters/joseph_update.h"

#include <algorithm>
#include <vector>

#include "core/linear_algebra/mirror.h"

namespace credence {
namespace {

/// The states that a batch measures, each once: the vehicle's, then those of the landmarks.
std::vector<Index> measured_states(const ObservationBatch& batch) {
  std::vector<Index> states;
  for (Index r = 0; r < batch.vehicle(); ++r) states.push_back(r);
  for (Index o = 0; o < batch.size(); ++o) {
    for (Index a = 0; a < batch.landmark() && batch.column(o) >= 0; ++a) {
      states.push_back(batch.vehicle() + batch.column(o) + a);
    }
  }
  std::sort(states.begin(), states.end());
  states.erase(std::unique(states.begin(), states.end()), states.end());
  return states;
}

/// The columns of H at `states`.
Matrix compact_jacobian(const ObservationBatch& batch, const std::vector<Index>& states) {
  Matrix H = Matrix::Zero(batch.rows(), static_cast<Index>(states.size()));
  for (Index o = 0; o < batch.size(); ++o) {
    const Index first = batch.vehicle() + batch.column(o);
    const auto at = std::lower_bound(states.begin(), states.end(), first) - states.begin();
    for (Index i = 0; i < batch.measurements(); ++i) {
      const Index row = batch.measurements() * o + i;
      for (Index r = 0; r < batch.vehicle(); ++r) H(row, r) = batch.H_r(o)[i * batch.vehicle() + r];
      for (Index a = 0; a < batch.landmark() && batch.column(o) >= 0; ++a) {
        H(row, at + a) = batch.H_l(o)[i * batch.landmark() + a];
      }
    }
  }
  return H;
}

}  // namespace

void joseph_update(Matrix& P, const ObservationBatch& batch, const Matrix& K, const Matrix& R) {
  const std::vector<Index> states = measured_states(batch);
  const Matrix H = compact_jacobian(batch, states);
  const auto c = static_cast<Index>(states.size());
  const Matrix T = Matrix::Identity(c, c) - K(states, Eigen::all) * H;
  Matrix KR(K.rows(), K.cols());
  for (Index o = 0; o < batch.size(); ++o) {
    const Index first = batch.measurements() * o;
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
