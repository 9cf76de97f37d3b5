#include "core/filters/estimators/oc_estimator.h"

namespace credence::internal {

void OcEstimator::started() {
  FirstLandmarkEstimator::started();
  moves_ = false;
  turn_ = pose().head<2>();
}

void OcEstimator::propagate(const Pose& before, const Motion& motion, const Control&, const PlanarTruth&) {
  before_ = before.head<2>();
  moved_ = motion.pose.head<2>() - before_;
  noise_ = motion.G * settings().Q * motion.G.transpose();
  propagate_pose(plane_motion(Point::Zero(), moved_), noise_);
  turn_ += moved_;
  moves_ = true;
}

void OcEstimator::choose_motion() {
  moves_ = false;
  // The mean of what p* − p̂_{k|k} would be for the pose and for each landmark.
  const Point turn_before = turn_ - moved_;
  Point shift = Point::Zero();
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Index offset = seen()[3 + 2 * i];
    shift += landmark(offset) - first_landmark(offset) + turn_before - before_;
  }
  shift /= static_cast<double>(seen_z().size() + 1);
  const PoseMatrix F = motion_jacobian(), E = plane_motion(shift, Point::Zero());
  propagate_pose(E, noise_ - E * noise_ * E.transpose());  // E Φ in the place of Φ
  set_motion_jacobian(E * F);
  turn_ -= shift;
}

void OcEstimator::linearise(const PlanarTruth&) {
  if (moves_) choose_motion();
  set_plane_rows(pose(),
                 [this](Index offset) -> Point { return first_landmark(offset) - turn_ + pose().head<2>(); });
}

}  // namespace credence::internal
