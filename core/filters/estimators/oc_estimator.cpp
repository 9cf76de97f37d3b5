#include "core/filters/estimators/oc_estimator.h"

#include "core/manifold/rotation.h"

namespace credence {

OcEstimator::OcEstimator(const EstimatorSettings& settings) : SlamEstimator(settings) {
  first_.reserve(static_cast<std::size_t>(settings.landmarks));
}

void OcEstimator::started() {
  first_.clear();
  turn_ = pose().head<2>();
}

void OcEstimator::propagate(const Pose& before, const Motion& motion, const Control&, const PlanarTruth&) {
  before_ = before.head<2>();
  moved_ = motion.pose.head<2>() - before_;
  noise_ = motion.G * settings().Q * motion.G.transpose();
  propagate_pose(plane_motion(Point::Zero(), moved_), noise_);
  turn_ += moved_;
}

void OcEstimator::linearise(const PlanarTruth&) {
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

  Jacobian H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Index offset = seen()[3 + 2 * i];
    plane_jacobian(pose(), first_landmark(offset) - turn_ + pose().head<2>(), H_r, H_l);
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), landmark(offset)), H_r, H_l);
  }
}

void OcEstimator::place(const Eigen::Vector2d& z, const PlanarTruth&, Jacobian& J_r, Eigen::Matrix2d& J_z) {
  first_.push_back(landmark(size() - 2));
  J_r << Eigen::Matrix2d::Identity(), quarter_turn(first_.back() - turn_);
  J_z = rotation(pose()[2]) * settings().sensor.inverse_jacobian(z);
}

}  // namespace credence
