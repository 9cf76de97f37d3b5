#include "core/filters/estimators/slam_estimator.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence::internal {

SlamEstimator::SlamEstimator(const EstimatorSettings& settings) : settings_(settings) {
  if (settings.landmarks < 0) throw std::invalid_argument("the number of landmarks must not be negative");
  if (!(settings.sigma_spread > 0.0 && settings.sigma_spread <= 1.0)) {
    throw std::invalid_argument(
        fmt::format("a spread of sigma points must be in (0, 1], it is {}", settings.sigma_spread));
  }
  if (settings.window < 1) throw std::invalid_argument("the window of a smoother must be at least 1");
  const Index most = 3 + 2 * settings.landmarks;
  const auto count = static_cast<std::size_t>(settings.landmarks);
  x_.setZero(most);
  P_.setZero(most, most);
  offsets_.resize(count);
  ids_.reserve(count);
  z_.reserve(count);
  placements_.reserve(count);
  seen_.reserve(count * 2 + 3);
}

void SlamEstimator::reset(const Pose& pose, const PoseMatrix& P) {
  n_ = 3;
  ids_.clear();
  std::ranges::fill(offsets_, -1);
  x_.head<3>() = pose;
  P_.topLeftCorner<3, 3>() = P;
  F_.setIdentity();
  nu_.resize(0);
  S_.resize(0, 0);
  W_.resize(n_, 0);
  started();
}

void SlamEstimator::predict(const Control& u, const PlanarTruth& truth) {
  const Pose before = pose();
  const Motion motion = settings_.model.move(before, u);
  x_.head<3>() = motion.pose;
  propagate(before, motion, u, truth);
}

UpdateResult SlamEstimator::update(Batch observations, const PlanarTruth& truth) {
  UpdateResult result;
  result.trace_prior = P_.diagonal().head(n_).sum();
  collect(observations);
  result.dof = 2 * std::ssize(z_);
  if (result.dof > 0) {
    linearise(truth);
    if (!correct(result)) {
      result.ok = false;
      return result;
    }
  } else {
    W_.resize(n_, 0);
  }
  for (const Observation<PlanarModel>& o : observations) {
    if (offsets_[static_cast<std::size_t>(o.landmark)] >= 0) continue;
    append(o, truth);
    ++result.initialised;
  }
  result.ok = refine(observations, truth);
  result.converged = converged_;
  return result;
}

UpdateResult SlamEstimator::judge(Batch observations, const PlanarTruth& truth) {
  UpdateResult result;
  collect(observations);
  result.dof = 2 * std::ssize(z_);
  if (result.dof == 0) return result;
  linearise(truth);
  result.ok = correct(result);
  result.converged = converged_;
  return result;
}

void SlamEstimator::collect(Batch observations) {
  require_each_once(observations);
  seen_.assign({0, 1, 2});
  converged_ = true;
  z_.clear();
  placements_.clear();
  for (const Observation<PlanarModel>& o : observations) {
    if (o.landmark < 0 || o.landmark >= settings_.landmarks) {
      throw std::invalid_argument(fmt::format("landmark {} of {} was seen", o.landmark, settings_.landmarks));
    }
    const Index offset = offsets_[static_cast<std::size_t>(o.landmark)];
    if (offset < 0) continue;
    seen_.push_back(offset);
    seen_.push_back(offset + 1);
    z_.push_back(o.z);
  }
  const Index m = 2 * std::ssize(z_);
  nu_.resize(m);
  H_.resize(m, std::ssize(seen_)).setZero();
  added_covariance_.resize(m, m).setZero();
}

void SlamEstimator::set_rows(Index i, const Eigen::Vector2d& nu, const Jacobian& H_r,
                             const Eigen::Matrix2d& H_l) {
  nu_.vector().segment<2>(2 * i) = nu;
  auto H = H_.matrix();
  H.block<2, 3>(2 * i, 0) = H_r;
  H.block<2, 2>(2 * i, 3 + 2 * i) = H_l;
}

Eigen::Matrix3d SlamEstimator::pose_covariance() const {
  return P_.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
}

Eigen::Map<Matrix> SlamEstimator::seen_covariance() {
  auto A = seen_P_.resize(std::ssize(seen_), std::ssize(seen_));
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) {
      const Index r = seen_[static_cast<std::size_t>(i)], c = seen_[static_cast<std::size_t>(j)];
      A(i, j) = r >= c ? P_(r, c) : P_(c, r);
    }
  }
  return A;
}

void SlamEstimator::propagate_pose(const PoseMatrix& F, const PoseMatrix& Q_r) {
  F_ = F;
  const PoseMatrix P_rr = pose_covariance();
  const PoseMatrix moved = F * P_rr * F.transpose() + Q_r;
  P_.topLeftCorner<3, 3>() = 0.5 * (moved + moved.transpose());
  const Index f = n_ - 3;
  if (f == 0) return;
  auto old = columns_.resize(f, 3);
  old = P_.block(3, 0, f, 3);
  P_.block(3, 0, f, 3) = old.lazyProduct(F.transpose());
}

bool SlamEstimator::correct(UpdateResult& result) {
  const auto H = H_.matrix();
  const Index m = H.rows(), s = H.cols();
  auto columns = columns_.resize(n_, s);  // P over the states that are seen
  for (Index j = 0; j < s; ++j) {
    const Index c = seen_[static_cast<std::size_t>(j)];
    columns.col(j).head(c) = P_.row(c).head(c).transpose();
    columns.col(j).tail(n_ - c) = P_.col(c).segment(c, n_ - c);
  }
  auto Y = W_.resize(n_, m);  // P Hᵀ, and then W
  Y.setZero();
  for (Index r = 0; r < m; ++r) {
    for (Index j = 0; j < s; ++j) {
      if (H(r, j) != 0.0) Y.col(r) += H(r, j) * columns.col(j);
    }
  }
  auto S = S_.resize(m, m);
  S = added_covariance_.matrix();
  for (Index r = 0; r < m; ++r) {
    for (Index j = 0; j < s; ++j) {
      if (H(r, j) != 0.0) S.row(r) += H(r, j) * Y.row(seen_[static_cast<std::size_t>(j)]);
    }
  }
  for (Index i = 0; i < m; i += 2) S.block<2, 2>(i, i) += settings_.R;
  symmetrise(S);
  auto L = L_.resize(m, m);
  L = S;
  const Eigen::LLT<Eigen::Ref<Matrix>> llt(L);
  if (llt.info() != Eigen::Success || !S.allFinite()) return false;

  auto w = whitened_.resize(m);
  w = nu_.vector();
  llt.matrixL().solveInPlace(w);
  result.nis = w.squaredNorm();
  for (Index c = 0; c < m; ++c) {  // W = Y L⁻ᵀ
    for (Index k = 0; k < c; ++k) Y.col(c) -= L(c, k) * Y.col(k);
    Y.col(c) /= L(c, c);
  }
  delta_.resize(n_);
  auto delta = delta_.vector();
  delta.setZero();
  for (Index c = 0; c < m; ++c) delta += w(c) * Y.col(c);
  apply(Y, delta);
  retract(delta);
  return true;
}

SlamEstimator::Correction SlamEstimator::start_correction(Index m) {
  S_.resize(m, m).setZero();
  L_.resize(m, m).setZero();
  W_.resize(n_, m).setZero();
  return {S_.matrix(), L_.matrix(), W_.matrix()};
}

Eigen::Map<Matrix> SlamEstimator::show_jacobians(const PoseMatrix& F, std::span<const Index> states,
                                                 Index rows) {
  F_ = F;
  seen_.assign(states.begin(), states.end());
  placements_.clear();
  auto H = H_.resize(rows, std::ssize(seen_));
  H.setZero();
  return H;
}

void SlamEstimator::apply(Eigen::Map<Matrix>& W, Eigen::Map<Vector>&) {
  const Index m = W.cols(), panels = panels_of(n_);
  const auto size = static_cast<std::size_t>(panels * kPanelRows * m);
  if (W_panels_.size() < size) W_panels_.resize(size);
  using Panel = Eigen::Matrix<double, kPanelRows, Eigen::Dynamic>;
  for (Index p = 0; p < panels; ++p) {  // the rows that fill up the last are never stored
    const Index rows = std::min<Index>(kPanelRows, n_ - kPanelRows * p);
    Eigen::Map<Panel>(W_panels_.data() + kPanelRows * m * p, kPanelRows, m).topRows(rows) =
        W.middleRows(kPanelRows * p, rows);
  }
  kernel_->downdate({.P = P_.data(),
                     .rows = n_,
                     .stride = P_.rows(),
                     .W = W_panels_.data(),
                     .panel_stride = kPanelRows * m,
                     .columns = m});
}

Matrix SlamEstimator::gain() const {
  Matrix K = W_.matrix();
  const auto L = L_.matrix();
  if (K.cols() == 0) return K;
  return L.triangularView<Eigen::Lower>().solve<Eigen::OnTheRight>(K);  // K L = W
}

void SlamEstimator::retract(const VectorRef& delta) {
  x_.head(n_) += delta;
  x_[2] = wrap_angle(x_[2]);
}

void SlamEstimator::append(const Observation<PlanarModel>& observation, const PlanarTruth& truth) {
  const Index offset = n_;
  offsets_[static_cast<std::size_t>(observation.landmark)] = offset;
  ids_.push_back(observation.landmark);
  n_ += 2;
  x_.segment<2>(offset) = x_.head<2>() + rotation(x_[2]) * settings_.sensor.locate(observation.z);
  Eigen::Matrix2d J_z;
  Jacobian& J_r = placements_.emplace_back();
  place(observation.z, truth, J_r, J_z);
  const PoseMatrix P_rr = pose_covariance();
  P_.block<2, 3>(offset, 0) = J_r * P_rr;
  for (Index j = 3; j < offset; ++j) {
    P_.block<2, 1>(offset, j) = J_r * P_.row(j).head<3>().transpose();
  }
  const Eigen::Matrix2d own = J_r * P_rr * J_r.transpose() + J_z * settings_.R * J_z.transpose();
  P_.block<2, 2>(offset, offset) = 0.5 * (own + own.transpose());
}

void SlamEstimator::place(const Eigen::Vector2d& z, const PlanarTruth&, Jacobian& J_r, Eigen::Matrix2d& J_z) {
  plane_placement(x_.segment<2>(n_ - 2) - x_.head<2>(), z, J_r, J_z);
}

void SlamEstimator::plane_placement(const Eigen::Vector2d& away, const Eigen::Vector2d& z, Jacobian& J_r,
                                    Eigen::Matrix2d& J_z) const {
  J_r << Eigen::Matrix2d::Identity(), quarter_turn(away);
  J_z = rotation(x_[2]) * settings_.sensor.inverse_jacobian(z);
}

void SlamEstimator::error(const PlanarTruth& truth, Eigen::Ref<Vector> error) const {
  error.head<3>() = x_.head<3>() - truth.now;
  error[2] = wrap_angle(error[2]);
  for (Index j = 3; j < n_; j += 2) {
    error.segment<2>(j) = landmark(j) - truth.landmarks[static_cast<std::size_t>(number_at(j))];
  }
}

Eigen::Matrix3d SlamEstimator::plane_motion(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  PoseMatrix F = PoseMatrix::Identity();
  F.topRightCorner<2, 1>() = quarter_turn(to - from);
  return F;
}

Matrix SlamEstimator::plane_covariance() const { return covariance().selfadjointView<Eigen::Lower>(); }

Eigen::Matrix3d SlamEstimator::plane_pose_covariance() const { return pose_covariance(); }

Eigen::Vector2d SlamEstimator::predicted(const Pose& pose, const Point& landmark) const {
  return settings_.sensor.measure(rotation(pose[2]).transpose() * (landmark - pose.head<2>()));
}

void SlamEstimator::plane_jacobian(const Pose& pose, const Point& landmark, Jacobian& H_r,
                                   Eigen::Matrix2d& H_l) const {
  const Eigen::Matrix2d Rt = rotation(pose[2]).transpose();
  const Eigen::Vector2d away = landmark - pose.head<2>();
  H_l = settings_.sensor.jacobian(Rt * away) * Rt;
  H_r << -H_l, -H_l * quarter_turn(away);
}

}  // namespace credence::internal
