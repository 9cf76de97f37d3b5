#include "core/filters/estimators/fej_estimator.h"

namespace credence::internal {

void FejEstimator::started() {
  FirstLandmarkEstimator::started();
  first_pose_ = pose();
}

void FejEstimator::propagate(const Pose&, const Motion& motion, const Control&, const PlanarTruth&) {
  propagate_pose(plane_motion(first_pose_.head<2>(), motion.pose.head<2>()),
                 motion.G * settings().Q * motion.G.transpose());
  first_pose_ = motion.pose;
}

void FejEstimator::linearise(const PlanarTruth&) {
  set_plane_rows(first_pose_, [this](Index offset) { return first_landmark(offset); });
}

}  // namespace credence::internal
