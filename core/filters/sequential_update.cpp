#include "core/filters/sequential_update.h"

#include <cmath>

#include "core/inflation/rank_one_bound.h"

namespace credence {
namespace {

/// Takes l lᵀ from P, and inflates the map blocks so that they stay uncorrelated.
void reduce(Matrix& P, const BlockLayout& layout, const VectorRef& l, MapBound which, MatrixBuffer& buffer) {
  const Index nr = layout.vehicle, nf = P.rows() - nr, d = layout.landmark;
  P.topLeftCorner(nr, nr).noalias() -= l.head(nr) * l.head(nr).transpose();
  P.topRightCorner(nr, nf).noalias() -= l.head(nr) * l.tail(nf).transpose();
  P.bottomLeftCorner(nf, nr) = P.topRightCorner(nr, nf).transpose();

  if (which == MapBound::drop) return;
  const ReductionBound bound = rank_one_bound(l.tail(nf), d);
  if (!lowers_trace(bound.excess, P.diagonal().tail(nf).sum())) return;
  auto blocks = buffer.resize(d, nf);
  for (Index j = 0; j < nf; j += d) blocks.middleCols(j, d) = P.block(nr + j, nr + j, d, d);
  reduce_and_inflate(bound, l.tail(nf), d, blocks);
  for (Index j = 0; j < nf; j += d) P.block(nr + j, nr + j, d, d) = blocks.middleCols(j, d);
}

}  // namespace

bool sequential_update(Matrix& P, const BlockLayout& layout, const MatrixRef& H, const VectorRef& r,
                       Eigen::Ref<Matrix> K, SequentialWorkspace& workspace, MapBound bound) {
  K.setZero();
  workspace.reduction.resize(P.rows());
  auto ph = workspace.reduction.vector();
  auto combination = workspace.combination.resize(1, H.rows()).row(0);
  for (Index i = 0; i < H.rows(); ++i) {
    ph.noalias() = P * H.row(i).transpose();
    const double s = H.row(i).dot(ph) + r[i];
    if (!(s > 0.0 && std::isfinite(s))) return false;
    // x_i = x_{i−1} + k_i (z_i − h_i x_{i−1}) and x_{i−1} = x⁻ + K ν give row e_i − h_i K.
    combination.noalias() = -H.row(i) * K;
    combination[i] += 1.0;
    K.noalias() += ph / s * combination;
    ph /= std::sqrt(s);
    reduce(P, layout, ph, bound, workspace.blocks);
  }
  return true;
}

}  // namespace credence
