#include "core/filters/sequential_update.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/inflation/batch_bound.h"
#include "core/inflation/rank_one_bound.h"

namespace credence::internal {
namespace {

/// Takes l lᵀ, of one or several columns, from the vehicle and its correlations.
template <typename Reduction>
void reduce_vehicle(Matrix& P, Index nr, const Reduction& l) {
  const Index nf = P.rows() - nr;
  P.topLeftCorner(nr, nr).noalias() -= l.topRows(nr) * l.topRows(nr).transpose();
  P.topRightCorner(nr, nf).noalias() -= l.topRows(nr) * l.bottomRows(nf).transpose();
  P.bottomLeftCorner(nf, nr) = P.topRightCorner(nr, nf).transpose();
}

/// Takes l lᵀ from P, and inflates the map blocks so that they stay uncorrelated.
void reduce(Matrix& P, const BlockLayout& layout, const VectorRef& l, MapBound which, MatrixBuffer& buffer) {
  const Index nr = layout.vehicle, nf = P.rows() - nr, d = layout.landmark;
  reduce_vehicle(P, nr, l);
  if (which == MapBound::drop) return;
  const ReductionBound bound = rank_one_bound(l.tail(nf), d);
  if (!lowers_trace(bound.excess, P.diagonal().tail(nf).sum())) return;
  auto blocks = buffer.resize(d, nf);
  for (Index j = 0; j < nf; j += d) blocks.middleCols(j, d) = P.block(nr + j, nr + j, d, d);
  reduce_and_inflate(bound, l.tail(nf), d, blocks);
  for (Index j = 0; j < nf; j += d) P.block(nr + j, nr + j, d, d) = blocks.middleCols(j, d);
}

/// The landmarks of which H has a column that is not zero, in the order of its rows.
std::vector<Index> measured_landmarks(const BlockLayout& layout, const MatrixRef& H) {
  std::vector<Index> measured;
  for (Index i = 0; i < H.rows(); ++i) {
    for (Index j = 0; j < layout.landmarks; ++j) {
      if (H.row(i).segment(layout.landmark_offset(j), layout.landmark).isZero(0.0)) continue;
      if (std::ranges::find(measured, j) == measured.end()) measured.push_back(j);
    }
  }
  return measured;
}

/// Adds to the map's blocks of P what the bound of D − L Lᵀ asks, L (n_f×c) being what a batch with the
/// vehicle's part G (n_r×c) of H took.
template <int r, int d>
void inflate_batch(Matrix& P, const BlockLayout& layout, const MatrixRef& L, const MatrixRef& G,
                   const std::vector<Index>& measured) {
  if (d * std::ssize(measured) > kMostBatchScalars) {
    throw std::invalid_argument("the bound of a batch takes d scalars a landmark");
  }
  const BatchBasis<r> Q = batch_basis<r>(G);
  BatchRows rows(d * static_cast<Index>(measured.size()), L.cols());
  for (std::size_t i = 0; i < measured.size(); ++i) {
    rows.template middleRows<d>(d * static_cast<Index>(i)) = L.template middleRows<d>(d * measured[i]);
  }
  using Common = Eigen::Matrix<double, d, r>;
  const auto is_measured = [&](Index j) { return std::ranges::find(measured, j) != measured.end(); };
  const auto common = [&](Index j) { return Common(L.template middleRows<d>(d * j) * Q); };
  BatchOthers<r> others;
  for (Index j = 0; j < layout.landmarks; ++j) {
    if (!is_measured(j)) others.add(common(j));
  }
  const double map_trace = P.diagonal().tail(d * layout.landmarks).sum();
  const BatchBound<r, d> bound = batch_bound<r, d>(rows, Q, others, map_trace);
  if (!bound.lowers) return;
  const auto block = [&](Index j) {
    return P.block<d, d>(layout.landmark_offset(j), layout.landmark_offset(j));
  };
  for (std::size_t i = 0; i < measured.size(); ++i) {
    block(measured[i]) += bound.changes.template middleCols<d>(d * static_cast<Index>(i));
  }
  for (Index j = 0; j < layout.landmarks; ++j) {
    if (!is_measured(j)) block(j) += bound.growth(common(j));
  }
}

/// At most kMostBatchScalars scalars, rows of H, at once: `ph` (n×c) is P Hᵀ and becomes what they take from
/// P.
bool batch_group_update(Matrix& P, const BlockLayout& layout, const MatrixRef& H, const VectorRef& r,
                        Eigen::Ref<Matrix> ph, Matrix& combination) {
  const Index nr = layout.vehicle, nf = P.rows() - nr;
  ph.noalias() = P * H.transpose();
  Matrix S = H * ph;
  S.diagonal() += r;
  const Eigen::LLT<Matrix> llt(S);
  if (llt.info() != Eigen::Success || !S.allFinite()) return false;
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(ph);
  llt.matrixL().solveInPlace(combination);
  Matrix G = H.leftCols(nr).transpose();
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(G);

  reduce_vehicle(P, nr, ph);
  const std::vector<Index> measured = measured_landmarks(layout, H);
  const Matrix L = ph.bottomRows(nf);
  if (nr == 3 && layout.landmark == 2) {
    inflate_batch<3, 2>(P, layout, L, G, measured);
  } else if (nr == 1 && layout.landmark == 1) {
    inflate_batch<1, 1>(P, layout, L, G, measured);
  } else {
    throw std::invalid_argument("the bound of a batch is for the plane and the line");
  }
  return true;
}

bool batch_update(Matrix& P, const BlockLayout& layout, const MatrixRef& H, const VectorRef& r,
                  Eigen::Ref<Matrix> K) {
  const Index scalars = H.rows(), group = batch_group(scalars);
  for (Index i = 0; i < scalars; i += group) {
    const Index c = std::min(group, scalars - i);
    Matrix combination = -H.middleRows(i, c) * K, ph(P.rows(), c);
    combination.middleCols(i, c) += Matrix::Identity(c, c);
    if (!batch_group_update(P, layout, H.middleRows(i, c), r.segment(i, c), ph, combination)) return false;
    K.noalias() += ph * combination;
  }
  return true;
}

}  // namespace

bool sequential_update(Matrix& P, const BlockLayout& layout, const MatrixRef& H, const VectorRef& r,
                       Eigen::Ref<Matrix> K, SequentialWorkspace& workspace, MapBound bound) {
  K.setZero();
  if (bound == MapBound::batch) return batch_update(P, layout, H, r, K);
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

}  // namespace credence::internal
