#include "core/filters/spatial/spatial_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/manifold/chart.h"

namespace credence::internal {
namespace {

constexpr SpatialKind kSpatialKinds[] = {
    {"ekf", "attitude in SO(3), positions by differences, Jacobians at the newest estimates",
     SpatialPoint::estimate, SpatialChart::componentwise},
    {"ideal", "the same with Jacobians at the truth: the yardstick", SpatialPoint::truth,
     SpatialChart::componentwise},
    {"fej", "the same with Jacobians at the first estimates", SpatialPoint::first,
     SpatialChart::componentwise},
    {"invariant", "right-invariant error of pose and landmarks", SpatialPoint::estimate, SpatialChart::whole},
    {"ekf-se3", "pose in SE(3), landmarks by differences", SpatialPoint::estimate, SpatialChart::pose},
};

constexpr Index kPoseDim = 6, kAttitude = 3;  // x = [p, φ, …]

/// Columns c … c + count − 1 of the symmetric matrix whose lower triangle is P.
Matrix columns_of(const Matrix& P, Index c, Index count) {
  Matrix columns(P.rows(), count);
  columns.topRows(c) = P.block(c, 0, count, c).transpose();
  columns.bottomRows(P.rows() - c) = P.block(c, c, P.rows() - c, count);
  const Eigen::MatrixXd own = P.block(c, c, count, count).selfadjointView<Eigen::Lower>();
  columns.middleRows(c, count) = own;
  return columns;
}

}  // namespace

std::span<const SpatialKind> spatial_kinds() { return kSpatialKinds; }

const SpatialKind& spatial_kind(std::string_view name) {
  const auto found = std::ranges::find(kSpatialKinds, name, &SpatialKind::name);
  if (found == std::end(kSpatialKinds)) {
    throw std::invalid_argument(fmt::format("no estimator of spatial SLAM is called \"{}\"", name));
  }
  return *found;
}

void SpatialSlam::reset(const SE3& pose, const PoseMatrix& P) {
  pose_ = first_pose_ = pose;
  landmarks_.clear();
  first_.clear();
  numbers_.clear();
  places_.assign(static_cast<std::size_t>(most_), -1);
  P_ = P;
}

const SE3& SpatialSlam::pose_point(const SpatialTruth& truth) const {
  if (kind_.point == SpatialPoint::truth) return truth.now;
  return kind_.point == SpatialPoint::first ? first_pose_ : pose_;
}

Eigen::Vector3d SpatialSlam::landmark_point(Index i, const SpatialTruth& truth) const {
  const auto at = static_cast<std::size_t>(i);
  if (kind_.point == SpatialPoint::truth) return truth.landmarks[static_cast<std::size_t>(numbers_[at])];
  return kind_.point == SpatialPoint::first ? first_[at] : landmarks_[at];
}

void SpatialSlam::predict(const SpatialControl& read, const SpatialTruth& truth) {
  const SE3 turn(SO3::Exp(read.omega), read.v);
  SE3 from = pose_;
  pose_ = pose_ * turn;
  SE3 to = pose_;
  if (kind_.point == SpatialPoint::truth) {
    from = truth.before;
    to = truth.now;
  } else if (kind_.point == SpatialPoint::first) {
    std::swap(from, first_pose_);
    first_pose_ = pose_;
  }
  const Eigen::Matrix3d moved = cross_matrix(to.translation() - from.translation());
  const Eigen::Matrix3d of_v = from.rotation().matrix();
  const Eigen::Matrix3d of_omega = to.rotation().matrix() * right_jacobian<SO3>(read.omega);
  PoseMatrix F = PoseMatrix::Identity(), Q = PoseMatrix::Zero();
  F.topRightCorner<3, 3>() = -moved;
  Q.topLeftCorner<3, 3>() = of_v * read.variances.head<3>().asDiagonal() * of_v.transpose();
  Q.bottomRightCorner<3, 3>() = of_omega * read.variances.tail<3>().asDiagonal() * of_omega.transpose();
  PoseMatrix P_pp = F * pose_covariance() * F.transpose() + Q;
  symmetrise(P_pp);
  P_.topLeftCorner<6, 6>() = P_pp;
  if (const Index map = size() - kPoseDim; map > 0) {
    const Matrix old = P_.block(kPoseDim, 0, map, kPoseDim);
    P_.block(kPoseDim, 0, map, kPoseDim) = old * F.transpose();
  }
  F_ = has_own_chart() ? PoseMatrix::Identity() : F;
}

void SpatialSlam::show(int number, Rows H_r, const Eigen::Matrix3d& H_l, const Eigen::Vector3d& about) {
  if (kind_.chart != SpatialChart::componentwise) {
    H_r.rightCols<3>() -= H_r.leftCols<3>() * cross_matrix(pose_.translation());
  }
  if (kind_.chart == SpatialChart::whole) H_r.rightCols<3>() -= H_l * cross_matrix(about);
  rows_.push_back({number, H_r, H_l});
}

bool SpatialSlam::update(std::span<const SpatialObservation> observations, const SpatialTruth& truth) {
  rows_.clear();
  const Index n = size();
  Index known = 0;
  for (const SpatialObservation& observation : observations) {
    known += places_.at(static_cast<std::size_t>(observation.landmark)) >= 0 ? 1 : 0;
  }
  const Index m = 3 * known;
  nu_.resize(m);
  S_.resize(m, m);
  if (m > 0) {
    const SE3& at = pose_point(truth);
    const Eigen::Matrix3d Rt = at.rotation().matrix().transpose();
    const SE3 back = pose_.inverse();
    const Matrix of_pose = columns_of(P_, 0, kPoseDim);
    Matrix Y(n, m);  // P Hᵀ
    Vector R(m);
    Index i = 0;
    for (const SpatialObservation& observation : observations) {
      const Index place = places_[static_cast<std::size_t>(observation.landmark)];
      if (place < 0) continue;
      Rows H_r;
      H_r << -Rt, Rt * cross_matrix(landmark_point(place, truth) - at.translation());
      const Matrix of_landmark = columns_of(P_, kPoseDim + 3 * place, 3);
      Y.middleCols<3>(3 * i) = of_pose * H_r.transpose() + of_landmark * Rt.transpose();
      nu_.segment<3>(3 * i) =
          observation.z - (back.rotation().matrix() * landmark(place) + back.translation());
      R.segment<3>(3 * i) = observation.variances;
      rows_.push_back({observation.landmark, H_r, Rt});
      ++i;
    }
    for (i = 0; i < known; ++i) {  // S = H Y + R
      const SpatialRows& row = rows_[static_cast<std::size_t>(i)];
      const Index place = places_[static_cast<std::size_t>(row.landmark)];
      S_.middleRows<3>(3 * i) = row.pose * Y.topRows<6>() + row.own * Y.middleRows<3>(kPoseDim + 3 * place);
    }
    S_.diagonal() += R;
    symmetrise(S_);
    const Eigen::LLT<Matrix> llt(S_);
    if (!S_.allFinite() || llt.info() != Eigen::Success) return false;
    const std::vector<SpatialRows> used = std::move(rows_);
    rows_.clear();
    for (const SpatialRows& row : used) {
      show(row.landmark, row.pose, row.own, landmark(places_[static_cast<std::size_t>(row.landmark)]));
    }
    Vector whitened = nu_;
    llt.matrixL().solveInPlace(whitened);
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(Y);  // W = Y L⁻ᵀ
    const Vector delta = Y * whitened;
    correct(delta, Y);
  }
  for (const SpatialObservation& observation : observations) {
    if (places_[static_cast<std::size_t>(observation.landmark)] < 0) place(observation, truth);
  }
  return true;
}

void SpatialSlam::correct(const Vector& delta, const Matrix& W) {
  const Index n = size(), m = W.cols();
  const Eigen::Vector3d phi = delta.segment<3>(kAttitude);
  const SO3 turn = SO3::Exp(phi);
  const Eigen::Matrix3d V = SO3::left_jacobian(phi);
  const auto with_group = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& d) -> Eigen::Vector3d {
    return turn * x + V * (d + x.cross(phi));
  };
  Matrix D = Matrix::Zero(n, 3);  // δ_i ← δ_i + D_i φ
  const bool pose_turns = has_own_chart(), all_turn = kind_.chart == SpatialChart::whole;
  Eigen::Vector3d p = pose_.translation();
  const Eigen::Vector3d dp = delta.head<3>();
  const Eigen::Vector3d p_new = pose_turns ? with_group(p, dp) : Eigen::Vector3d(p + dp);
  if (pose_turns) D.topRows<3>() = -cross_matrix(p_new - p);
  pose_ = SE3(turn * pose_.rotation(), p_new);
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const Index at = kPoseDim + 3 * static_cast<Index>(i);
    const Eigen::Vector3d d = delta.segment<3>(at), l = landmarks_[i];
    landmarks_[i] = all_turn ? with_group(l, d) : Eigen::Vector3d(l + d);
    if (all_turn) D.middleRows<3>(at) = -cross_matrix(landmarks_[i] - l);
  }
  if (!pose_turns) {
    product_.add_lower(P_, ProductFactor::minus(W), ProductFactor::transposed(W));
    return;
  }
  // P − W Wᵀ, and then moved: + D Bᵀ + B Dᵀ, B = P_φ + ½ D P_φφ.
  const Matrix C = columns_of(P_, kAttitude, 3) - W * W.middleRows<3>(kAttitude).transpose();
  const Matrix B = C + 0.5 * D * C.middleRows<3>(kAttitude);
  Matrix left(n, m + 6), right(n, m + 6);
  left << -W, D, B;
  right << W, B, D;
  product_.add_lower(P_, left, ProductFactor::transposed(right));
}

void SpatialSlam::place(const SpatialObservation& observation, const SpatialTruth& truth) {
  const Index n = size();
  const Eigen::Matrix3d R = pose_.rotation().matrix();
  const Eigen::Vector3d l = pose_.translation() + R * observation.z;
  places_[static_cast<std::size_t>(observation.landmark)] = std::ssize(landmarks_);
  landmarks_.push_back(l);
  first_.push_back(l);
  numbers_.push_back(observation.landmark);
  const SE3& at = pose_point(truth);
  const Eigen::Vector3d away = landmark_point(std::ssize(landmarks_) - 1, truth) - at.translation();
  const Eigen::Matrix3d J_z = kind_.point == SpatialPoint::truth ? at.rotation().matrix() : R;
  Rows J_r;
  J_r << Eigen::Matrix3d::Identity(), -cross_matrix(away);
  P_.conservativeResize(n + 3, n + 3);
  const PoseMatrix P_pp = pose_covariance();
  P_.block<3, 6>(n, 0) = J_r * P_pp;
  if (n > kPoseDim) {
    P_.block(n, kPoseDim, 3, n - kPoseDim) = J_r * P_.block(kPoseDim, 0, n - kPoseDim, kPoseDim).transpose();
  }
  Eigen::Matrix3d own =
      J_r * P_pp * J_r.transpose() + J_z * observation.variances.asDiagonal() * J_z.transpose();
  symmetrise(own);
  P_.block<3, 3>(n, n) = own;
  show(observation.landmark, -J_r, Eigen::Matrix3d::Identity(), l);
}

SpatialSlam::PoseMatrix SpatialSlam::pose_covariance() const {
  return P_.topLeftCorner<6, 6>().selfadjointView<Eigen::Lower>();
}

SpatialSlam::PoseMatrix SpatialSlam::own_pose_covariance() const {
  if (!has_own_chart()) return pose_covariance();
  PoseMatrix T = PoseMatrix::Identity();
  T.topRightCorner<3, 3>() = cross_matrix(pose_.translation());
  return T * pose_covariance() * T.transpose();
}

Eigen::Matrix<double, 6, 1> SpatialSlam::pose_error(const SE3& truth, bool own_chart) const {
  return minus(truth, pose_, own_chart && has_own_chart() ? Chart::left : Chart::componentwise_left);
}

SpatialSlam::MapError SpatialSlam::map_error(const SpatialTruth& truth) const {
  const Index map = size() - kPoseDim;
  MapError result{Vector(map), P_.bottomRightCorner(map, map)};
  const bool turned = kind_.chart == SpatialChart::whole;
  const Eigen::Vector3d phi = pose_error(truth.now, false).tail<3>();
  const Eigen::Matrix3d back = SO3::left_jacobian_inverse(phi), turn = SO3::Exp(phi).matrix();
  Matrix X(map, 3);
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const Eigen::Vector3d& l = truth.landmarks[static_cast<std::size_t>(numbers_[i])];
    const Index at = 3 * static_cast<Index>(i);
    result.error.segment<3>(at) =
        turned ? Eigen::Vector3d(back * (l - turn * landmarks_[i])) : Eigen::Vector3d(l - landmarks_[i]);
    X.middleRows<3>(at) = cross_matrix(landmarks_[i]);
  }
  if (!turned) return result;
  const Matrix C = P_.block(kPoseDim, kAttitude, map, 3);
  const Eigen::Matrix3d P_phi = pose_covariance().bottomRightCorner<3, 3>();
  const Matrix B = C + 0.5 * X * P_phi;
  result.P.triangularView<Eigen::Lower>() += X * B.transpose();
  result.P.triangularView<Eigen::Lower>() += B * X.transpose();
  return result;
}

}  // namespace credence::internal
