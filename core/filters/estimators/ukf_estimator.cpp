#include "core/filters/estimators/ukf_estimator.h"

#include "core/manifold/angle.h"

namespace credence::internal {

void UkfEstimator::propagate(const Pose& before, const Motion& motion, const Control& u, const PlanarTruth&) {
  Eigen::Matrix<double, 5, 5> P = Eigen::Matrix<double, 5, 5>::Zero();
  P.topLeftCorner<3, 3>() = pose_covariance();
  P.bottomRightCorner<2, 2>() = settings().Q;
  motion_.take(P, 3, settings().sigma_spread, [&](const VectorRef& step, Eigen::Ref<Vector> y) {
    y = settings().model.vehicle.moved(before + step.head<3>(), u + step.tail<2>(), settings().model.dt_s) -
        motion.pose;
    y[2] = wrap_angle(y[2]);
  });
  const Eigen::Matrix3d L = motion_.root().topLeftCorner<3, 3>(), curvature = motion_.curvature();
  const Eigen::Matrix<double, 3, 2> D_u = motion_.D().rightCols<2>();
  Eigen::Matrix3d A = motion_.D().leftCols<3>();
  const Eigen::Matrix3d F = plane_motion(before.head<2>(), motion.pose.head<2>());
  for (Index j = 0; j < 3; ++j) {
    if (L(j, j) == 0.0) A.col(j) = F.col(j);  // nothing is spread there
  }
  const Eigen::Ref<const Matrix> root = motion_.root().topLeftCorner(3, 3);
  auto columns = motion_.D().leftCols(3);
  columns = A;
  divide_by_root(columns, root);
  propagate_pose(columns, D_u * D_u.transpose() + curvature);
  x().head<3>() += motion_.shift();
  x()[2] = wrap_angle(x()[2]);
}

void UkfEstimator::linearise(const PlanarTruth&) {
  set_sigma_rows(
      measurement_,
      [](Pose& pose, Point& landmark, const Pose& pose_step, const Point& step) {
        pose += pose_step;
        landmark += step;
      },
      [this](const Pose& pose, const Point& landmark, Jacobian& H_r, Eigen::Matrix2d& H_l) {
        plane_jacobian(pose, landmark, H_r, H_l);
      });
}

}  // namespace credence::internal
