#include "analysis/stability/observability_stack.h"

#include <algorithm>

#include "analysis/stability/dense_svd.h"
#include "core/linear_algebra/decompositions.h"

namespace credence::internal {

ObservabilityStack::ObservabilityStack(Index states)
    : states_(states), stack_(Matrix::Zero(3 * states, states)) {}

void ObservabilityStack::add(const VectorRef& row) {
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

Matrix ObservabilityStack::rows() {
  reduce();
  return stack_.topRows(rows_);
}

RankDecision ObservabilityStack::rank() { return decide_rank(dense_svd(rows()).s); }

}  // namespace credence::internal
