#include "core/filters/arrow_covariance.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

namespace credence::internal {
namespace {

using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;
using SmallMatrix = ArrowCovariance::VehicleMatrix;

/// L⁻¹ of a small psd block with its zero-variance states left out; kept[i] are those that are not.
struct SmallFactor {
  bool ok = true;
  Index dof = 0;
  Index kept[3] = {};
  Eigen::LLT<SmallMatrix> llt;

  /// `zero` says which states of P have no variance; P itself may be a Schur complement.
  template <class Zero>
  SmallFactor(const SmallMatrix& P, Zero zero) {
    for (Index i = 0; i < P.rows(); ++i) {
      if (!zero(i)) kept[dof++] = i;
    }
    if (dof == 0) return;
    SmallMatrix kept_P(dof, dof);
    for (Index i = 0; i < dof; ++i) {
      for (Index j = 0; j < dof; ++j) kept_P(i, j) = P(kept[i], kept[j]);
    }
    llt.compute(kept_P);
    ok = llt.info() == Eigen::Success && kept_P.allFinite();
  }

  template <class Source>
  SmallVector whitened(const Source& e) const {
    SmallVector w(dof);
    for (Index i = 0; i < dof; ++i) w[i] = e[kept[i]];
    if (dof > 0) llt.matrixL().solveInPlace(w);
    return w;
  }
};

SmallFactor factor_of(const SmallMatrix& P) {
  return {P, [&P](Index i) { return P(i, i) == 0.0; }};
}

/// A stride of an odd number of packs: arrays at multiples of 4 KB would share their places in the cache.
Index stride_for(Index landmarks) {
  const Index packs = (landmarks + kMapPack - 1) / kMapPack;
  return kMapPack * (packs | 1);
}

}  // namespace

ArrowCovariance::ArrowCovariance(Index vehicle, Index landmark)
    : layout_{.vehicle = vehicle, .landmark = landmark, .landmarks = 0} {
  if (vehicle < 1 || vehicle > 3 || landmark < 1 || landmark > 2) {
    throw std::invalid_argument(fmt::format(
        "ArrowCovariance: a vehicle of {} and landmarks of {} are not supported", vehicle, landmark));
  }
  rr_.setZero(vehicle, vehicle);
}

ArrowCovariance ArrowCovariance::of(MatrixRef P, const BlockLayout& layout) {
  if (P.rows() != layout.state_dim() || P.cols() != layout.state_dim()) {
    throw std::invalid_argument(fmt::format("ArrowCovariance: P is {}x{}, its layout is of {}", P.rows(),
                                            P.cols(), layout.state_dim()));
  }
  ArrowCovariance arrow(layout.vehicle, layout.landmark);
  const Index n = layout.vehicle, d = layout.landmark;
  arrow.set_vehicle(P.topLeftCorner(n, n));
  arrow.reserve(layout.landmarks);
  for (Index j = 0; j < layout.landmarks; ++j) {
    const Index at = layout.landmark_offset(j);
    arrow.append(P.block(0, at, n, d), P.block(at, at, d, d));
  }
  return arrow;
}

void ArrowCovariance::set_vehicle(const MatrixRef& P) {
  for (Index a = 0; a < layout_.vehicle; ++a) {
    for (Index b = 0; b < layout_.vehicle; ++b) rr_(a, b) = P(a, b);
  }
}

ArrowCovariance::CrossMatrix ArrowCovariance::cross(Index j) const {
  CrossMatrix out(layout_.vehicle, layout_.landmark);
  for (Index a = 0; a < out.rows(); ++a) {
    for (Index c = 0; c < out.cols(); ++c) out(a, c) = values_[cross_at(a, c, j)];
  }
  return out;
}

void ArrowCovariance::set_cross(Index j, const CrossMatrix& rf) {
  for (Index a = 0; a < rf.rows(); ++a) {
    for (Index c = 0; c < rf.cols(); ++c) values_[cross_at(a, c, j)] = rf(a, c);
  }
}

ArrowCovariance::LandmarkMatrix ArrowCovariance::block(Index j) const {
  LandmarkMatrix out(layout_.landmark, layout_.landmark);
  out(0, 0) = values_[block_at(0, j)];
  if (layout_.landmark == 2) {
    out(0, 1) = out(1, 0) = values_[block_at(1, j)];
    out(1, 1) = values_[block_at(2, j)];
  }
  return out;
}

void ArrowCovariance::set_block(Index j, const LandmarkMatrix& P) {
  values_[block_at(0, j)] = P(0, 0);
  if (layout_.landmark == 2) {
    values_[block_at(1, j)] = P(1, 0);
    values_[block_at(2, j)] = P(1, 1);
  }
}

void ArrowCovariance::append(const CrossMatrix& rf, const LandmarkMatrix& P) {
  if (layout_.landmarks == stride_) reserve(std::max<Index>(kMapPack, 2 * stride_));
  const Index j = layout_.landmarks++;
  set_cross(j, rf);
  set_block(j, P);
}

void ArrowCovariance::reserve(Index landmarks) {
  const Index stride = stride_for(landmarks);
  if (stride <= stride_) return;
  AlignedVector values(static_cast<std::size_t>(array_count() * stride), 0.0);
  for (Index a = 0; a < array_count(); ++a) {
    std::copy_n(values_.begin() + a * stride_, layout_.landmarks, values.begin() + a * stride);
  }
  values_ = std::move(values);
  stride_ = stride;
}

double ArrowCovariance::trace_of_map() const {
  double sum = 0.0;
  for (Index j = 0; j < layout_.landmarks; ++j) {
    sum += values_[block_at(0, j)];
    if (layout_.landmark == 2) sum += values_[block_at(2, j)];
  }
  return sum;
}

double ArrowCovariance::variance(Index i) const {
  if (i < layout_.vehicle) return rr_(i, i);
  const Index j = (i - layout_.vehicle) / layout_.landmark;
  const Index c = (i - layout_.vehicle) % layout_.landmark;
  return values_[block_at(c == 0 ? 0 : 2, j)];
}

Matrix ArrowCovariance::dense() const {
  const Index n = layout_.vehicle, d = layout_.landmark;
  Matrix P = Matrix::Zero(state_dim(), state_dim());
  P.topLeftCorner(n, n) = rr_;
  for (Index j = 0; j < landmarks(); ++j) {
    const Index at = layout_.landmark_offset(j);
    P.block(0, at, n, d) = cross(j);
    P.block(at, 0, d, n) = cross(j).transpose();
    P.block(at, at, d, d) = block(j);
  }
  return P;
}

BlockMapArrays ArrowCovariance::arrays() {
  const Index cross_arrays = layout_.vehicle * layout_.landmark;
  return {.rf = values_.data(),
          .blocks = values_.data() + cross_arrays * stride_,
          .stride = stride_,
          .packs = (layout_.landmarks + kMapPack - 1) / kMapPack};
}

ArrowNees arrow_nees(VectorRef e, const ArrowCovariance& P) {
  if (e.size() != P.state_dim()) {
    throw std::invalid_argument(
        fmt::format("arrow_nees: the error has {} entries, P {}", e.size(), P.state_dim()));
  }
  ArrowNees out;
  const Index n = P.layout().vehicle, d = P.layout().landmark;
  out.positive_definite = factor_of(P.vehicle()).ok;

  SmallMatrix schur = P.vehicle();
  SmallVector residual = e.head(n);
  for (Index j = 0; j < P.landmarks() && out.positive_definite; ++j) {
    const ArrowCovariance::CrossMatrix rf = P.cross(j);
    const SmallFactor factor = factor_of(SmallMatrix(P.block(j)));
    out.positive_definite = factor.ok;
    if (!factor.ok) break;
    const SmallVector w = factor.whitened(e.segment(P.layout().landmark_offset(j), d));
    SmallMatrix half(factor.dof, n);  // L⁻¹ P_fr
    for (Index a = 0; a < n; ++a) half.col(a) = factor.whitened(rf.row(a));
    out.nees += w.squaredNorm();
    out.dof += factor.dof;
    residual -= half.transpose().lazyProduct(w);
    schur -= half.transpose().lazyProduct(half);
  }
  const SmallFactor vehicle(schur, [&P](Index i) { return P.vehicle()(i, i) == 0.0; });
  out.positive_definite = out.positive_definite && vehicle.ok;
  if (!out.positive_definite) return out;
  out.nees += vehicle.whitened(residual).squaredNorm();
  out.dof += vehicle.dof;
  return out;
}

}  // namespace credence::internal
