#include "core/filters/estimators/invariant_estimator.h"

#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence::internal {
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
  add_pose_noise(motion.pose, motion.G * settings().Q * motion.G.transpose());
}

void InvariantEstimator::add_pose_noise(const Pose& pose, const PoseMatrix& Q_r) {
  const Index n = size();
  auto G = G_.resize(n, 3);
  G.topRows<3>() = to_plane(-pose.head<2>());
  for (Index j = 3; j < n; j += 2) {
    G.block<2, 2>(j, 0).setZero();
    G.block<2, 1>(j, 2) = -quarter_turn(landmark(j));
  }
  for (Index j = 0; j < n; ++j) {
    const Eigen::Vector3d g = Q_r * G.row(j).transpose();
    auto column = P().col(j).segment(j, n - j);
    column += g[2] * G.col(2).tail(n - j);
    for (Index i = j; i < 3; ++i) P()(i, j) += g[0] * G(i, 0) + g[1] * G(i, 1);
  }
}

void InvariantEstimator::invariant_jacobian(const Pose& pose, const Point& landmark, Jacobian& H_r,
                                            Eigen::Matrix2d& H_l) const {
  const Eigen::Matrix2d Rt = rotation(pose[2]).transpose();
  H_l = settings().sensor.jacobian(Rt * (landmark - pose.head<2>())) * Rt;
  H_r << -H_l, Eigen::Vector2d::Zero();
}

void InvariantEstimator::linearise(const PlanarTruth&) {
  Jacobian H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Point l = landmark(seen()[3 + 2 * i]);
    invariant_jacobian(pose(), l, H_r, H_l);
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
  if (reset_ == InvariantReset::left) transport(R, V, delta);
  if (reset_ == InvariantReset::full) transport(V, exponential_curvature(delta[2]), delta);
}

void InvariantEstimator::transport(const Eigen::Matrix2d& A, const Eigen::Matrix2d& B,
                                   const VectorRef& delta) {
  const Index n = size();
  Matrix& C = P();
  const double variance = C(2, 2);
  auto q = q_.resize(n, 2);               // q_i, and A cov(ε_i, ε_φ) + ½ q_i var ε_φ
  const auto points = [n](auto&& take) {  // of all points, by their first state
    take(Index{0});
    for (Index i = 3; i < n; i += 2) take(i);
  };
  points([&](Index i) {
    const Eigen::Vector2d along =
        i == 0 ? Eigen::Vector2d(C(2, 0), C(2, 1)) : Eigen::Vector2d(C.block<2, 1>(i, 2));
    q.block<2, 1>(i, 0) = -quarter_turn(B * delta.segment<2>(i));
    q.block<2, 1>(i, 1) = A * along + 0.5 * variance * q.block<2, 1>(i, 0);
  });
  points([&](Index j) {
    points([&](Index i) {
      if (i < j) return;
      Eigen::Matrix2d block = C.block<2, 2>(i, j);
      if (i == j) block(0, 1) = block(1, 0);
      C.block<2, 2>(i, j) = A * block * A.transpose() +
                            q.block<2, 1>(i, 1) * q.block<2, 1>(j, 0).transpose() +
                            q.block<2, 1>(i, 0) * q.block<2, 1>(j, 1).transpose();
    });
    const Eigen::Vector2d along = q.block<2, 1>(j, 1) + 0.5 * variance * q.block<2, 1>(j, 0);
    if (j == 0) {
      C.block<1, 2>(2, 0) = along.transpose();
    } else {
      C.block<2, 1>(j, 2) = along;
    }
  });
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

Matrix InvariantEstimator::plane_covariance() const {
  Vector turned = Vector::Zero(size());  // δ = e + turned e_θ
  turned.head<2>() = quarter_turn(pose().head<2>());
  for (Index j = 3; j < size(); j += 2) turned.segment<2>(j) = quarter_turn(landmark(j));
  Matrix P = SlamEstimator::plane_covariance();
  const Vector along = P.col(2) + 0.5 * P(2, 2) * turned;
  P += turned * along.transpose() + along * turned.transpose();
  return P;
}

Eigen::Matrix3d InvariantEstimator::plane_pose_covariance() const {
  const PoseMatrix T = to_plane(pose().head<2>());
  return T * pose_covariance() * T.transpose();
}

}  // namespace credence::internal
