#include "core/filters/estimators/smoother_estimator.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>

#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence::internal {

SmootherEstimator::SmootherEstimator(const EstimatorSettings& settings, bool first_estimates)
    : EkfEstimator(settings),
      first_estimates_(first_estimates),
      width_(3 + 2 * settings.landmarks),
      frames_(static_cast<std::size_t>(settings.window) + 1),
      points_(Vector::Zero(width_)) {
  for (Prior* prior : {&prior_, &next_}) {
    prior->mean.setZero(width_);
    prior->P.setZero(width_, width_);
  }
  const Index rows = width_ + 3 * std::ssize(frames_);
  d_.setZero(rows);
  C_.setZero(rows, width_);
  states_.reserve(static_cast<std::size_t>(width_));
  for (Frame& frame : frames_) frame.seen.reserve(static_cast<std::size_t>(settings.landmarks));
}

void SmootherEstimator::started() {
  count_ = 1;
  frames_[0].pose = pose();
  frames_[0].seen.clear();
  moved_.setZero();
  moved_noise_.setZero();
  prior_.size = 3;
  prior_.mean.head<3>() = pose();
  prior_.P.topLeftCorner<3, 3>() = pose_covariance();
  prior_.point = pose();
  prior_.motion.setIdentity();
}

void SmootherEstimator::propagate(const Pose& before, const Motion& motion, const Control& u,
                                  const PlanarTruth& truth) {
  EkfEstimator::propagate(before, motion, u, truth);
  const Motion local = settings().model.move(moved_, u);
  const PoseMatrix F = plane_motion(moved_.head<2>(), local.pose.head<2>());
  moved_noise_ = (F * moved_noise_ * F.transpose() + local.G * settings().Q * local.G.transpose()).eval();
  moved_ = local.pose;
}

bool SmootherEstimator::refine(Batch observations, const PlanarTruth&) {
  constexpr double kSettled = 1e-5;  // m, rad
  show_nothing();
  if (observations.empty()) return true;
  Frame& now = frames_[count_++];
  now.pose = pose();
  now.moved = moved_;
  now.noise = moved_noise_;
  now.seen.assign(observations.begin(), observations.end());
  moved_.setZero();
  moved_noise_.setZero();
  double change = 0.0, share = 1.0;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const double last = change;
    change = iterate(share);
    if (!(change > kSettled)) break;
    if (iteration >= kPlainIterations && !(change < last)) share = 0.5;  // it goes to and fro
  }
  if (change > kSettled) set_not_converged();
  if (is_full()) move_window();
  return change == change;
}

double SmootherEstimator::iterate(double share) {
  start_pass();
  for (std::size_t j = 0; j < count_; ++j) {
    if (j > 0) predict_frame(j);
    if (j == 1 && is_full()) keep_prior();
    if (!correct_frame(j)) return std::numeric_limits<double>::quiet_NaN();
    for (const Observation<PlanarModel>& o : frames_[j].seen) {
      if (offset_of(o.landmark) >= n_) place_landmark(o, j);
    }
  }
  return finish_pass(share);
}

void SmootherEstimator::start_pass() {
  n_ = prior_.size;
  clones_ = 0;
  C_.topLeftCorner(n_, n_) = prior_.P.topLeftCorner(n_, n_);
  C_.middleRows(n_, width_ - n_).setZero();  // landmarks that are not placed yet
  d_.head<3>() = prior_.mean.head<3>() - frames_[0].pose;
  d_[2] = wrap_angle(d_[2]);
  d_.segment(3, n_ - 3) = prior_.mean.segment(3, n_ - 3) - x().segment(3, n_ - 3);
  d_.segment(n_, width_ - n_).setZero();
}

void SmootherEstimator::predict_frame(std::size_t j) {
  const Pose& from = frames_[j - 1].pose;
  const Frame& to = frames_[j];
  C_.block(clone(clones_), 0, 3, n_) = C_.topRows<3>().leftCols(n_);
  d_.segment<3>(clone(clones_)) = d_.head<3>();
  ++clones_;

  const Pose& point = pose_point(j - 1);
  PoseMatrix turn = PoseMatrix::Identity();
  turn.topLeftCorner<2, 2>() = rotation(from[2]);
  Pose residual = from + turn * to.moved - to.pose;
  residual[2] = wrap_angle(residual[2]);
  F_now_ = plane_motion(point.head<2>(), to.pose.head<2>());  // with the noise that this way means
  turn.topLeftCorner<2, 2>() = rotation(point[2]);

  d_.head<3>() = (F_now_ * d_.head<3>() + residual).eval();
  const PoseMatrix P_rr =
      F_now_ * C_.topLeftCorner<3, 3>() * F_now_.transpose() + turn * to.noise * turn.transpose();
  for (Index axis = 0; axis < 2; ++axis) {  // C Fᵀ, whose rows are those of I but for the heading
    C_.col(axis).head(n_) += F_now_(axis, 2) * C_.col(2).head(n_);
    C_.col(axis).segment(width_, clone(clones_) - width_) +=
        F_now_(axis, 2) * C_.col(2).segment(width_, clone(clones_) - width_);
  }
  for (Index r = 3; r < n_; ++r) C_.col(r).head<3>() = C_.row(r).head<3>().transpose();
  C_.topLeftCorner<3, 3>() = 0.5 * (P_rr + P_rr.transpose());
}

Eigen::Vector2d SmootherEstimator::linearised(const Observation<PlanarModel>& o, std::size_t j, Index offset,
                                              Jacobian& H_r, Eigen::Matrix2d& H_l) const {
  plane_jacobian(pose_point(j), landmark_point(offset), H_r, H_l);
  return settings().sensor.innovation(o.z, predicted(frames_[j].pose, landmark(offset)));
}

bool SmootherEstimator::correct_frame(std::size_t j) {
  states_.assign(kPoseStates.begin(), kPoseStates.end());
  for (const Observation<PlanarModel>& o : frames_[j].seen) {
    const Index offset = offset_of(o.landmark);
    if (offset >= n_) continue;
    states_.push_back(offset);
    states_.push_back(offset + 1);
  }
  const Index s = std::ssize(states_), m = s - 3;
  if (m == 0) return true;
  auto H = H_pass_.resize(m, s), S = S_pass_.resize(m, m), nu = nu_pass_.resize(m);
  H.setZero();
  Index i = 0;
  for (const Observation<PlanarModel>& o : frames_[j].seen) {
    const Index offset = offset_of(o.landmark);
    if (offset >= n_) continue;
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    nu.middleRows<2>(i) = linearised(o, j, offset, H_r, H_l);
    nu.middleRows<2>(i) -= H_r * d_.head<3>() + H_l * d_.segment<2>(offset);
    H.block<2, 3>(i, 0) = H_r;
    H.block<2, 2>(i, 3 + i) = H_l;
    i += 2;
  }
  auto W = W_pass_.resize(clone(clones_), m);
  W.setZero();
  for (Index r = 0; r < m; ++r) {
    for (Index k = 0; k < s; ++k) {
      if (H(r, k) != 0.0) W.col(r) += H(r, k) * C_.col(states_[static_cast<std::size_t>(k)]).head(W.rows());
    }
  }
  S.setZero();  // its lower triangle
  for (Index r = 0; r < m; ++r) {
    for (Index k = 0; k < s; ++k) {
      if (H(r, k) != 0.0)
        S.row(r).head(r + 1) += H(r, k) * W.row(states_[static_cast<std::size_t>(k)]).head(r + 1);
    }
  }
  for (Index r = 0; r < m; r += 2) S.block<2, 2>(r, r) += settings().R;
  if (!S_factor_.compute(S, W, nu_pass_.vector())) return false;
  S_factor_.add_correction(d_.head(W.rows()));
  S_factor_.downdate_columns(C_.topLeftCorner(W.rows(), n_));
  return true;
}

void SmootherEstimator::place_landmark(const Observation<PlanarModel>& o, std::size_t j) {
  Jacobian H_r;
  Eigen::Matrix2d H_l;
  const Eigen::Vector2d nu = linearised(o, j, n_, H_r, H_l);
  const Eigen::Matrix2d J_z = H_l.inverse();
  const Jacobian J_r = -J_z * H_r;
  d_.segment<2>(n_) = J_z * nu + J_r * d_.head<3>();
  for (Index c = 0; c < n_; ++c) {
    C_.block<2, 1>(n_, c) = J_r * C_.col(c).head<3>();
    C_.block<1, 2>(c, n_) = C_.block<2, 1>(n_, c).transpose();
  }
  for (Index r = width_; r < clone(clones_); ++r) {
    C_.block<1, 2>(r, n_) = C_.row(r).head<3>() * J_r.transpose();
  }
  C_.block<2, 2>(n_, n_) =
      J_r * C_.topLeftCorner<3, 3>() * J_r.transpose() + J_z * settings().R * J_z.transpose();
  n_ += 2;
}

double SmootherEstimator::finish_pass(double share) {
  double change = d_.head(n_).cwiseAbs().maxCoeff();
  for (std::size_t j = 0; j < count_; ++j) {
    const auto d = j + 1 < count_ ? d_.segment<3>(clone(j)) : d_.segment<3>(0);
    change = std::max(change, d.cwiseAbs().maxCoeff());
    frames_[j].pose += share * d;
    frames_[j].pose[2] = wrap_angle(frames_[j].pose[2]);
  }
  x().head<3>() = frames_[count_ - 1].pose;
  x().segment(3, n_ - 3) += share * d_.segment(3, n_ - 3);
  for (Index c = 0; c < n_; ++c) P().col(c).segment(c, n_ - c) = C_.col(c).segment(c, n_ - c);
  return change;
}

void SmootherEstimator::keep_prior() {
  next_.size = n_;
  next_.mean.head<3>() = frames_[1].pose + d_.head<3>();
  next_.mean.segment(3, n_ - 3) = x().segment(3, n_ - 3) + d_.segment(3, n_ - 3);
  next_.P.topLeftCorner(n_, n_) = C_.topLeftCorner(n_, n_);
  next_.point = frames_[1].pose;
  next_.motion = F_now_;
  points_.segment(prior_.size, n_ - prior_.size) = x().segment(prior_.size, n_ - prior_.size);

  // The Jacobians of the oldest frame will not change any more.
  states_.assign(kPoseStates.begin(), kPoseStates.end());
  for (const Observation<PlanarModel>& o : frames_[0].seen) {
    const Index offset = offset_of(o.landmark);
    if (offset >= prior_.size) continue;
    states_.push_back(offset);
    states_.push_back(offset + 1);
  }
  auto H = show_jacobians(prior_.motion, states_, std::ssize(states_) - 3);
  Index row = 0;
  for (const Observation<PlanarModel>& o : frames_[0].seen) {
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    const Index offset = offset_of(o.landmark);
    linearised(o, 0, offset, H_r, H_l);
    if (offset >= prior_.size) {
      shown_placements().push_back(-H_l.inverse() * H_r);
    } else {
      H.block<2, 3>(row, 0) = H_r;
      H.block<2, 2>(row, 3 + row) = H_l;
      row += 2;
    }
  }
}

void SmootherEstimator::move_window() {
  std::swap(prior_, next_);
  std::rotate(frames_.begin(), frames_.begin() + 1, frames_.end());
  --count_;
}

const Pose& SmootherEstimator::pose_point(std::size_t j) const {
  return first_estimates_ && j == 0 ? prior_.point : frames_[j].pose;
}

Point SmootherEstimator::landmark_point(Index offset) const {
  return first_estimates_ && offset < prior_.size ? Point(points_.segment<2>(offset)) : landmark(offset);
}

}  // namespace credence::internal
