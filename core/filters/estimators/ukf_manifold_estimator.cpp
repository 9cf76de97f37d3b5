#include "core/filters/estimators/ukf_manifold_estimator.h"

#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence::internal {

void UkfManifoldEstimator::propagate(const Pose& before, const Motion& motion, const Control& u,
                                     const PlanarTruth&) {
  set_motion_jacobian(PoseMatrix::Identity());
  const Eigen::Matrix2d Rt = rotation(motion.pose[2]).transpose();
  noise_.take(settings().Q, 3, settings().sigma_spread, [&](const VectorRef& step, Eigen::Ref<Vector> y) {
    const Pose read = settings().model.vehicle.moved(before, u + step.head<2>(), settings().model.dt_s);
    y[2] = wrap_angle(read[2] - motion.pose[2]);  // the logarithm in the vehicle's frame
    y.head<2>() = logarithm_factor(y[2]) * Rt * (read.head<2>() - motion.pose.head<2>());
  });
  const Eigen::Matrix<double, 3, 2> D = noise_.D();
  PoseMatrix Q_r = D * D.transpose() + noise_.curvature();
  PoseMatrix T = PoseMatrix::Identity();
  T.topLeftCorner<2, 2>() = Rt.transpose();
  Q_r = T * Q_r * T.transpose();
  add_pose_noise(motion.pose, Q_r);
}

void UkfManifoldEstimator::linearise(const PlanarTruth&) {
  set_sigma_rows(
      measurement_,
      [](Pose& pose, Point& landmark, const Pose& pose_step, const Point& step) {
        const Eigen::Matrix2d R = rotation(pose_step[2]), V = exponential_factor(pose_step[2]);
        pose.head<2>() = R * pose.head<2>() + V * pose_step.head<2>();
        pose[2] += pose_step[2];
        landmark = R * landmark + V * step;
      },
      [this](const Pose& pose, const Point& landmark, Jacobian& H_r, Eigen::Matrix2d& H_l) {
        invariant_jacobian(pose, landmark, H_r, H_l);
      });
}

}  // namespace credence::internal
