#include "core/filters/block_map_state.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/polar.h"

namespace credence::internal {
namespace {

/// (C Cᵀ)^{1/2} and (Cᵀ C)^{1/2}.
template <int d>
void two_block_roots(const Eigen::Matrix<double, d, d>& C, Eigen::Matrix<double, d, d>& left,
                     Eigen::Matrix<double, d, d>& right) {
  if constexpr (d == 1) {
    left = right = C.cwiseAbs();
  } else {
    static_assert(d == 2);
    const Eigen::Matrix2d U = orthogonal_factor(C);
    left.noalias() = C * U.transpose();
    right.noalias() = U.transpose() * C;
  }
}

}  // namespace

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::reset(VectorRef x, ArrowCovariance P) {
  x_ = x;
  P_ = std::move(P);
  rr_ = P_.vehicle();
  map_trace_ = P_.trace_of_map();
  T_.setIdentity();
  w_.setZero();
  pending_ = false;
  measured_.clear();
  measured_at_.assign(static_cast<std::size_t>(landmarks()), -1);
  make_room();
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::make_room() {
  const auto stride = static_cast<std::size_t>(P_.stride());
  if (shift_.size() >= stride * kLandmark) return;
  reciprocals_.assign(stride * kMaxDirections, 0.0);
  shift_.assign(stride * kLandmark, 0.0);
}

template <int kVehicle, int kLandmark>
auto BlockMapState<kVehicle, kLandmark>::position(Index j) const -> LandmarkVector {
  LandmarkVector position = x_.template segment<kLandmark>(kVehicle + kLandmark * j);
  if (pending_ && measured_at_[static_cast<std::size_t>(j)] < 0) {
    position += CrossMatrix(P_.cross(j)).transpose() * w_;
  }
  return position;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::predict(const VehicleMatrix& F, const VehicleMatrix& noise) {
  const VehicleMatrix predicted = F * rr_ * F.transpose() + noise;
  rr_ = 0.5 * (predicted + predicted.transpose());
  T_ = (F * T_).eval();
  for (Measured& m : measured_) m.cross = (F * m.cross).eval();
  pending_ = true;
}

template <int kVehicle, int kLandmark>
Index BlockMapState<kVehicle, kLandmark>::measure(Index j) {
  std::int32_t& at = measured_at_[static_cast<std::size_t>(j)];
  if (at >= 0) return at;
  x_.template segment<kLandmark>(kVehicle + kLandmark * j) = position(j);
  at = static_cast<std::int32_t>(measured_.size());
  Measured& added = measured_.emplace_back();
  added.j = j;
  added.cross = T_ * CrossMatrix(P_.cross(j));
  added.block = P_.block(j);
  P_.set_cross(j, CrossMatrix::Zero());
  return at;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::flush() {
  P_.set_vehicle(rr_);
  if (!pending_ && measured_.empty()) return;
  if (pending_ && landmarks() > measured_count()) {
    const Eigen::Matrix<double, kVehicle, kVehicle, kVehicle == 1 ? 0 : Eigen::RowMajor> rows = T_;
    kernel_->transform(P_.arrays(), rows.data(), w_.data(), shift_.data());
    double* map = x_.data() + kVehicle;
    for (Index j = 0; j < landmarks(); ++j) {
      for (Index c = 0; c < kLandmark; ++c) {
        map[kLandmark * j + c] += shift_[static_cast<std::size_t>(c * P_.stride() + j)];
      }
    }
  }
  for (const Measured& m : measured_) {
    P_.set_cross(m.j, m.cross);
    measured_at_[static_cast<std::size_t>(m.j)] = -1;
  }
  measured_.clear();
  T_.setIdentity();
  w_.setZero();
  pending_ = false;
}

template <int kVehicle, int kLandmark>
auto BlockMapState<kVehicle, kLandmark>::direction(int i) const -> VehicleVector {
  return Eigen::Map<const VehicleVector>(directions_.g[i]);
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::set_direction(int i, const VehicleVector& g) {
  Eigen::Map<VehicleVector>(directions_.g[i]) = g;
}

template <int kVehicle, int kLandmark>
bool BlockMapState<kVehicle, kLandmark>::prepare(const Scalar& scalar, Step& step) {
  step.column = rr_ * scalar.h_r;
  step.variance = scalar.r;
  step.excess = 0.0;
  for (Measured& m : measured_) m.column = m.cross.transpose() * scalar.h_r;
  if (scalar.measured >= 0) {
    Measured& seen = measured_[static_cast<std::size_t>(scalar.measured)];
    step.column += seen.cross * scalar.h_l;
    seen.column += seen.block * scalar.h_l;
    step.variance += seen.column.dot(scalar.h_l);
  }
  step.variance += step.column.dot(scalar.h_r);
  return step.variance > 0.0 && std::isfinite(step.variance);
}

/// Adds what the steps of this pass are due to the blocks of the map.
template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::inflate_blocks(std::span<Step> steps) {
  double excess[kMaxDirections] = {};
  bool any = false;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    excess[i] = steps[i].excess;
    any = any || excess[i] != 0.0;
    steps[i].excess = 0.0;
  }
  if (any) map_trace_ = kernel_->inflate(P_.arrays(), directions_, excess, reciprocals_.data());
}

/// The landmark of the largest norm in direction i.
template <int kVehicle, int kLandmark>
Index BlockMapState<kVehicle, kLandmark>::largest_of_map(int i) const {
  const auto first = reciprocals_.begin() + i * P_.stride();
  return std::min_element(first, first + landmarks()) - first;
}

/// The exact bound of step i, for the landmarks measured at once and for the others as an excess.
template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::settle_bound(const Scalar& scalar, std::span<Step> steps, int i) {
  Step& step = steps[static_cast<std::size_t>(i)];
  const double root = std::sqrt(step.variance);
  LargestNorm largest{norms_[i].largest / root, norms_[i].others / root};
  for (std::size_t k = 0; k < measured_.size(); ++k) {
    largest.take(static_cast<Index>(k), measured_[k].column.norm() / root);
  }
  if (!largest.dominates() || !lowers_trace(largest.norm - largest.others, map_trace_)) return;
  if (largest.at < 0) {
    // A landmark of the map's arrays keeps a share of its reduction: it is treated as a measured one.
    inflate_blocks(steps);
    measure(largest_of_map(i));
    compute_norms();
    prepare(scalar, step);
    return settle_bound(scalar, steps, i);
  }
  const double excess = largest.norm - largest.others, kept = largest.others / largest.norm - 1.0;
  for (std::size_t k = 0; k < measured_.size(); ++k) {
    Measured& m = measured_[k];
    const double norm = m.column.norm() / root;
    const bool distinguished = static_cast<Index>(k) == largest.at;
    if (!distinguished && norm == 0.0) continue;
    const double share = (distinguished ? kept : excess / norm) / step.variance;
    for (Index a = 0; a < kLandmark; ++a) {
      for (Index b = 0; b <= a; ++b) {
        m.block(a, b) += share * m.column[a] * m.column[b];
        m.block(b, a) = m.block(a, b);
      }
    }
    P_.set_block(m.j, m.block);
  }
  step.excess = excess / root;
}

/// Takes l lᵀ from the vehicle and its correlations, and moves the state.
template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::apply(const Scalar& scalar, const Step& step, int i) {
  double innovation = scalar.nu - scalar.h_r.dot(pose_change_);
  if (scalar.measured >= 0) innovation -= scalar.h_l.dot(measured(scalar.measured).change);
  const double move = innovation / step.variance;
  const VehicleVector l = step.column / std::sqrt(step.variance), share = step.column / step.variance;
  rr_ -= l * l.transpose();
  T_ -= share * direction(i).transpose();
  w_ += move * direction(i);
  pose_change_ += move * step.column;
  for (Measured& m : measured_) {
    m.cross -= share * m.column.transpose();
    m.change += move * m.column;
  }
  pending_ = true;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::add_to_gain(const Scalar& scalar, const Step& step, int i, Index row,
                                                     Matrix& gain) const {
  // x_i = x_{i−1} + k_i (z_i − h_i x_{i−1}) and x_{i−1} = x⁻ + K ν give row e_i − h_i K.
  Eigen::RowVectorXd combination = -scalar.h_r.transpose() * gain.template topRows<kVehicle>();
  if (scalar.measured >= 0) {
    const Index at = kVehicle + kLandmark * measured(scalar.measured).j;
    combination -= scalar.h_l.transpose() * gain.template middleRows<kLandmark>(at);
  }
  combination[row] += 1.0;
  combination /= step.variance;
  gain.template topRows<kVehicle>() += step.column * combination;
  for (Index j = 0; j < landmarks(); ++j) {
    const std::int32_t at = measured_at_[static_cast<std::size_t>(j)];
    const LandmarkVector column =
        at < 0 ? LandmarkVector(CrossMatrix(P_.cross(j)).transpose() * direction(i)) : measured(at).column;
    gain.template middleRows<kLandmark>(kVehicle + kLandmark * j) += column * combination;
  }
}

template <int kVehicle, int kLandmark>
bool BlockMapState<kVehicle, kLandmark>::correct_pass(std::span<const Scalar> scalars, MapBound bound,
                                                      Index first, Matrix* gain) {
  Step steps[kMaxDirections];
  const std::span<Step> used(steps, scalars.size());
  directions_.count = static_cast<int>(scalars.size());
  for (int i = 0; i < directions_.count; ++i) {
    const Scalar& scalar = scalars[static_cast<std::size_t>(i)];
    if (!prepare(scalar, steps[i])) return false;
    if (i == 0) {
      const VehicleVector g = T_.transpose() * scalar.h_r;
      set_direction(0, g);
      if (directions_.count == 2) {
        // T after the first scalar, which its bound has no part in: hence both norms in one pass.
        const VehicleVector& next = scalars[1].h_r;
        set_direction(1, T_.transpose() * next - g * (steps[0].column.dot(next) / steps[0].variance));
      }
      if (bound == MapBound::least_trace) compute_norms();
    }
    if (bound == MapBound::least_trace) settle_bound(scalar, used, i);
    if (gain != nullptr) add_to_gain(scalar, steps[i], i, first + i, *gain);
    apply(scalar, steps[i], i);
  }
  inflate_blocks(used);
  return true;
}

/// L and what belongs to it; `combination` receives C⁻¹ (E − H K), S = C Cᵀ.
template <int kVehicle, int kLandmark>
bool BlockMapState<kVehicle, kLandmark>::prepare(std::span<const Scalar> scalars, Group& group,
                                                 Matrix* combination) {
  const auto c = static_cast<Index>(scalars.size());
  for (Measured& m : measured_) m.row = -1;
  group_.clear();
  typename Group::Columns H_r(kVehicle, c);
  for (Index i = 0; i < c; ++i) {
    const Scalar& scalar = scalars[static_cast<std::size_t>(i)];
    H_r.col(i) = scalar.h_r;
    if (scalar.measured < 0) continue;
    Measured& seen = measured_[static_cast<std::size_t>(scalar.measured)];
    if (seen.row >= 0) continue;
    seen.row = kLandmark * static_cast<Index>(group_.size());
    group_.push_back(scalar.measured);
  }
  group.vehicle = rr_ * H_r;
  group.rows.resize(kLandmark * static_cast<Index>(group_.size()), c);
  for (const Index k : group_) {
    const Measured& seen = measured(k);
    group.rows.template middleRows<kLandmark>(seen.row) = seen.cross.transpose() * H_r;
  }
  for (Index i = 0; i < c; ++i) {
    const Scalar& scalar = scalars[static_cast<std::size_t>(i)];
    if (scalar.measured < 0) continue;
    const Measured& seen = measured(scalar.measured);
    group.vehicle.col(i) += seen.cross * scalar.h_l;
    group.rows.col(i).template segment<kLandmark>(seen.row) += seen.block * scalar.h_l;
  }
  BatchRows S(c, c);
  S.noalias() = H_r.transpose() * group.vehicle;
  group.move.resize(c);
  for (Index i = 0; i < c; ++i) {
    const Scalar& scalar = scalars[static_cast<std::size_t>(i)];
    S(i, i) += scalar.r;
    group.move[i] = scalar.nu - scalar.h_r.dot(pose_change_);
    if (scalar.measured < 0) continue;
    const Measured& seen = measured(scalar.measured);
    S.row(i) += scalar.h_l.transpose() * group.rows.template middleRows<kLandmark>(seen.row);
    group.move[i] -= scalar.h_l.dot(seen.change);
  }
  const Eigen::LLT<Eigen::Ref<BatchRows>> llt(S);
  if (llt.info() != Eigen::Success || !S.allFinite()) return false;
  group.g = H_r;
  llt.matrixU().template solveInPlace<Eigen::OnTheRight>(group.g);
  llt.matrixU().template solveInPlace<Eigen::OnTheRight>(group.vehicle);
  llt.matrixU().template solveInPlace<Eigen::OnTheRight>(group.rows);
  llt.matrixL().solveInPlace(group.move);
  if (combination != nullptr) llt.matrixL().solveInPlace(*combination);
  return true;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::inflate_group(const Group& group) {
  using Frame = Eigen::Matrix<double, kVehicle, kVehicle>;
  using Rows = Eigen::Matrix<double, kLandmark, kVehicle>;
  const BatchBasis<kVehicle> Q = batch_basis<kVehicle>(group.g);
  const Frame here = group.g * Q, there = T_.transpose() * here;
  const auto set_frame = [](BlockMapFrame& frame, const Frame& columns) {
    for (int i = 0; i < kVehicle; ++i) Eigen::Map<VehicleVector>(frame.g[i]) = columns.col(i);
  };
  BlockMapFrame frame;
  set_frame(frame, there);
  BlockMapMoments moments;
  kernel_->moments(P_.arrays(), frame, reciprocals_.data(), &moments);
  BatchOthers<kVehicle> others;
  others.norms = moments.norms;
  for (int i = 0, entry = 0; i < kVehicle; ++i) {
    for (int k = 0; k <= i; ++k, ++entry) {
      others.squares(i, k) = others.squares(k, i) = moments.squares[entry];
    }
  }
  for (const Measured& m : measured_) {
    if (m.row >= 0) continue;
    others.add(Rows(m.cross.transpose() * here));
  }
  const auto bound = batch_bound<kVehicle, kLandmark>(group.rows, Q, others, map_trace_);
  if (!bound.lowers) return;
  for (Measured& m : measured_) {
    if (m.row >= 0) {
      m.block += bound.changes.template middleCols<kLandmark>(m.row);
    } else {
      m.block += bound.growth(Rows(m.cross.transpose() * here));
    }
    P_.set_block(m.j, m.block);
  }
  set_frame(frame, there * bound.spread);
  map_trace_ = kernel_->spread(P_.arrays(), frame, reciprocals_.data());
}

/// Takes L Lᵀ from the vehicle and its correlations, and moves the state.
template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::apply(const Group& group) {
  const VehicleMatrix taken = group.vehicle * group.vehicle.transpose();
  rr_ -= 0.5 * (taken + taken.transpose());
  for (Measured& m : measured_) {
    Eigen::Matrix<double, kLandmark, Eigen::Dynamic, kLandmark == 1 ? Eigen::RowMajor : Eigen::ColMajor,
                  kLandmark, kMostBatchScalars>
        L;
    if (m.row >= 0) {
      L = group.rows.template middleRows<kLandmark>(m.row);
    } else {
      L = m.cross.transpose() * group.g;
    }
    m.cross -= group.vehicle * L.transpose();
    m.change += L * group.move;
  }
  w_ += T_.transpose() * (group.g * group.move);
  T_ -= (group.vehicle * group.g.transpose() * T_).eval();
  pose_change_ += group.vehicle * group.move;
  pending_ = true;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::add_to_gain(const Group& group, const Matrix& combination,
                                                     Matrix& gain) const {
  gain.template topRows<kVehicle>() += group.vehicle * combination;
  const Eigen::Matrix<double, kVehicle, Eigen::Dynamic> unmeasured = group.g * combination,
                                                        late = T_.transpose() * unmeasured;
  for (Index j = 0; j < landmarks(); ++j) {
    auto rows = gain.template middleRows<kLandmark>(kVehicle + kLandmark * j);
    const std::int32_t at = measured_at_[static_cast<std::size_t>(j)];
    if (at < 0) {
      rows += CrossMatrix(P_.cross(j)).transpose() * late;
    } else if (measured(at).row < 0) {
      rows += measured(at).cross.transpose() * unmeasured;
    } else {
      rows += group.rows.template middleRows<kLandmark>(measured(at).row) * combination;
    }
  }
}

template <int kVehicle, int kLandmark>
bool BlockMapState<kVehicle, kLandmark>::correct_group(std::span<const Scalar> scalars, Index first,
                                                       Matrix* gain) {
  Group group;
  if (gain == nullptr) {
    if (!prepare(scalars, group, nullptr)) return false;
  } else {
    const auto c = static_cast<Index>(scalars.size());
    Matrix combination(c, gain->cols());
    for (Index i = 0; i < c; ++i) {
      const Scalar& scalar = scalars[static_cast<std::size_t>(i)];
      combination.row(i) = -scalar.h_r.transpose() * gain->template topRows<kVehicle>();
      if (scalar.measured >= 0) {
        combination.row(i) -=
            scalar.h_l.transpose() *
            gain->template middleRows<kLandmark>(kVehicle + kLandmark * measured(scalar.measured).j);
      }
      combination(i, first + i) += 1.0;
    }
    if (!prepare(scalars, group, &combination)) return false;
    add_to_gain(group, combination, *gain);
  }
  inflate_group(group);
  apply(group);
  return true;
}

template <int kVehicle, int kLandmark>
bool BlockMapState<kVehicle, kLandmark>::correct(std::span<const Scalar> scalars, MapBound bound,
                                                 Matrix* gain) {
  pose_change_.setZero();
  for (Measured& m : measured_) m.change.setZero();
  if (gain != nullptr) gain->setZero(x_.size(), static_cast<Index>(scalars.size()));
  const bool by_groups = bound == MapBound::batch;
  const auto most = by_groups ? static_cast<std::size_t>(batch_group(std::ssize(scalars))) : kMaxDirections;
  for (std::size_t i = 0; i < scalars.size(); i += most) {
    const std::span<const Scalar> some = scalars.subspan(i, std::min(most, scalars.size() - i));
    const auto first = static_cast<Index>(i);
    if (!(by_groups ? correct_group(some, first, gain) : correct_pass(some, bound, first, gain)))
      return false;
  }
  x_.template head<kVehicle>() += pose_change_;
  for (const Measured& m : measured_) {
    x_.template segment<kLandmark>(kVehicle + kLandmark * m.j) += m.change;
  }
  return true;
}

template <int kVehicle, int kLandmark>
void BlockMapState<kVehicle, kLandmark>::append(const LandmarkVector& position,
                                                const Eigen::Matrix<double, kLandmark, kVehicle>& J,
                                                const LandmarkMatrix& own) {
  flush();
  LandmarkMatrix block = own, left, right;
  for (Index j = 0; j < landmarks(); ++j) {
    two_block_roots<kLandmark>(J * CrossMatrix(P_.cross(j)), left, right);
    block += left;
    P_.set_block(j, LandmarkMatrix(P_.block(j)) + right);
  }
  P_.append(CrossMatrix(rr_ * J.transpose()), LandmarkMatrix(0.5 * (block + block.transpose())));
  map_trace_ = P_.trace_of_map();
  x_.conservativeResize(x_.size() + kLandmark);
  x_.template tail<kLandmark>() = position;
  measured_at_.push_back(-1);
  make_room();
}

template <int kVehicle, int kLandmark>
std::size_t BlockMapState<kVehicle, kLandmark>::bytes() const {
  const std::size_t doubles =
      static_cast<std::size_t>(x_.size()) + P_.doubles() + reciprocals_.capacity() + shift_.capacity();
  return sizeof(double) * doubles + sizeof(std::int32_t) * measured_at_.capacity();
}

template class BlockMapState<3, 2>;
template class BlockMapState<1, 1>;

}  // namespace credence::internal
