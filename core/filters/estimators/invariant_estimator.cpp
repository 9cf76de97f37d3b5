#include "core/filters/estimators/invariant_estimator.h"

#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence {
namespace {

/// T of x̂ − x = T e to first order, for the pose: δp = e_p + J p̂ e_θ.
Eigen::Matrix3d to_plane(const Eigen::Vector2d& position) {
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topRightCorner<2, 1>() = quarter_turn(position);
  return T;
}

}  // namespace

void InvariantEstimator::started() {
  const PoseMatrix T = to_plane(-pose().head<2>());
  const PoseMatrix P_rr = T * pose_covariance() * T.transpose();
  P().topLeftCorner<3, 3>() = 0.5 * (P_rr + P_rr.transpose());
}

void InvariantEstimator::propagate(const Pose&, const Motion& motion, const Control&, const PlanarTruth&) {
  set_motion_jacobian(PoseMatrix::Identity());
  // Noise u + w moves x̂ − x by G w, and so e by T⁻¹ G w: that of the heading moves every point.
  const Index n = size();
  auto G = G_.resize(n, 2);
  G.topRows<3>() = to_plane(-motion.pose.head<2>()) * motion.G;
  for (Index j = 3; j < n; j += 2) G.block<2, 2>(j, 0) = -quarter_turn(landmark(j)) * motion.G.row(2);
  const Eigen::Matrix2d& Q = settings().Q;
  for (Index j = 0; j < n; ++j) {
    const Eigen::Vector2d g = Q * G.row(j).transpose();
    P().col(j).segment(j, n - j) += g[0] * G.col(0).tail(n - j) + g[1] * G.col(1).tail(n - j);
  }
}

void InvariantEstimator::linearise(const PlanarTruth&) {
  const Eigen::Matrix2d Rt = rotation(pose()[2]).transpose();
  Jacobian H_r;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Point l = landmark(seen()[3 + 2 * i]);
    const Eigen::Vector2d rho = Rt * (l - pose().head<2>());
    const Eigen::Matrix2d H_l = settings().sensor.jacobian(rho) * Rt;
    H_r << -H_l, Eigen::Vector2d::Zero();
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), l), H_r, H_l);
  }
}

void InvariantEstimator::retract(const VectorRef& delta) {
  const Eigen::Matrix2d R = rotation(delta[2]), V = exponential_factor(delta[2]);
  Vector& state = x();
  state.head<2>() = R * state.head<2>() + V * delta.head<2>();
  state[2] = wrap_angle(state[2] + delta[2]);
  for (Index j = 3; j < size(); j += 2) {
    state.segment<2>(j) = R * state.segment<2>(j) + V * delta.segment<2>(j);
  }
}

void InvariantEstimator::place(const Eigen::Vector2d& z, const PlanarTruth&, Jacobian& J_r,
                               Eigen::Matrix2d& J_z) {
  J_r << Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero();
  J_z = rotation(pose()[2]) * settings().sensor.inverse_jacobian(z);
}

void InvariantEstimator::error(const PlanarTruth& truth, Eigen::Ref<Vector> error) const {
  const double angle = wrap_angle(x()[2] - truth.now[2]);
  const Eigen::Matrix2d R = rotation(angle), V = logarithm_factor(angle);
  error.head<2>() = V * (x().head<2>() - R * truth.now.head<2>());
  error[2] = angle;
  for (Index j = 3; j < size(); j += 2) {
    error.segment<2>(j) = V * (landmark(j) - R * truth.landmarks[static_cast<std::size_t>(number_at(j))]);
  }
}

Eigen::Matrix3d InvariantEstimator::plane_pose_covariance() const {
  const PoseMatrix T = to_plane(pose().head<2>());
  return T * pose_covariance() * T.transpose();
}

}  // namespace credence
