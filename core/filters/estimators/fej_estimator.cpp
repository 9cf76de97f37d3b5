#include "core/filters/estimators/fej_estimator.h"

#include "core/manifold/rotation.h"

namespace credence {

FejEstimator::FejEstimator(const EstimatorSettings& settings) : SlamEstimator(settings) {
  first_.reserve(static_cast<std::size_t>(settings.landmarks));
}

void FejEstimator::started() {
  first_pose_ = pose();
  first_.clear();
}

void FejEstimator::propagate(const Pose&, const Motion& motion, const Control&, const PlanarTruth&) {
  propagate_pose(plane_motion(first_pose_.head<2>(), motion.pose.head<2>()),
                 motion.G * settings().Q * motion.G.transpose());
  first_pose_ = motion.pose;
}

void FejEstimator::linearise(const PlanarTruth&) {
  Jacobian H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Index offset = seen()[3 + 2 * i];
    plane_jacobian(first_pose_, first_landmark(offset), H_r, H_l);
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), landmark(offset)), H_r, H_l);
  }
}

void FejEstimator::place(const Eigen::Vector2d& z, const PlanarTruth&, Jacobian& J_r, Eigen::Matrix2d& J_z) {
  first_.push_back(landmark(size() - 2));
  J_r << Eigen::Matrix2d::Identity(), quarter_turn(first_.back() - first_pose_.head<2>());
  J_z = rotation(pose()[2]) * settings().sensor.inverse_jacobian(z);
}

}  // namespace credence
