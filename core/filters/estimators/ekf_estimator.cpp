#include "core/filters/estimators/ekf_estimator.h"

namespace credence {

void EkfEstimator::propagate(const Pose& before, const Motion& motion, const Control&, const PlanarTruth&) {
  propagate_pose(plane_motion(before.head<2>(), motion.pose.head<2>()),
                 motion.G * settings().Q * motion.G.transpose());
}

void EkfEstimator::linearise(const PlanarTruth&) {
  Jacobian H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Point l = landmark(seen()[3 + 2 * i]);
    plane_jacobian(pose(), l, H_r, H_l);
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), l), H_r, H_l);
  }
}

}  // namespace credence
