#include "core/filters/estimators/ekf_estimator.h"

namespace credence::internal {

void EkfEstimator::propagate(const Pose& before, const Motion& motion, const Control&, const PlanarTruth&) {
  propagate_pose(plane_motion(before.head<2>(), motion.pose.head<2>()),
                 motion.G * settings().Q * motion.G.transpose());
}

void EkfEstimator::linearise(const PlanarTruth&) {
  set_plane_rows(pose(), [this](Index offset) { return landmark(offset); });
}

}  // namespace credence::internal
