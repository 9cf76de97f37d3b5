#include "analysis/stability/observability_stack.h"

#include <algorithm>

#include "analysis/stability/dense_svd.h"
#include "core/linear_algebra/decompositions.h"

namespace credence {

ObservabilityStack::ObservabilityStack(Index states)
    : states_(states), stack_(Matrix::Zero(3 * states, states)), row_(states) {}

void ObservabilityStack::add(const SlamEstimator& filter) {
  transition_ = filter.motion_jacobian() * transition_;
  const MatrixRef H = filter.measurement_jacobian();
  for (Index r = 0; r < H.rows(); ++r) {
    row_.setZero();
    row_.head<3>() = (H.row(r).head<3>() * transition_).transpose();
    for (Index j = 3; j < H.cols(); ++j) row_[filter.seen()[static_cast<std::size_t>(j)]] = H(r, j);
    add_row(row_);
  }
  for (const Eigen::Matrix<double, 2, 3>& J_r : filter.placements()) {
    for (Index axis = 0; axis < 2; ++axis, ++known_) {
      row_.setZero();
      row_.head<3>() = -(J_r.row(axis) * transition_).transpose();
      row_[known_] = 1.0;
      add_row(row_);
    }
  }
}

void ObservabilityStack::add_row(const VectorRef& row) {
  if (rows_ == stack_.rows()) reduce();
  stack_.row(rows_++) = row.transpose();
}

void ObservabilityStack::reduce() {
  const Matrix rows = stack_.topRows(rows_);
  const Eigen::HouseholderQR<Matrix> qr(rows);
  const Index kept = std::min(rows_, states_);
  const Matrix R = qr.matrixQR().topRows(kept).triangularView<Eigen::Upper>();
  stack_.topRows(kept) = R;
  rows_ = kept;
}

RankDecision ObservabilityStack::rank(double tolerance) {
  reduce();
  return decide_rank(dense_svd(stack_.topRows(rows_)).s, tolerance);
}

}  // namespace credence
