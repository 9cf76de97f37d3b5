#include "core/filters/estimators/first_landmark_estimator.h"

namespace credence::internal {

FirstLandmarkEstimator::FirstLandmarkEstimator(const EstimatorSettings& settings) : SlamEstimator(settings) {
  first_.reserve(static_cast<std::size_t>(settings.landmarks));
}

void FirstLandmarkEstimator::place(const Eigen::Vector2d& z, const PlanarTruth&, Jacobian& J_r,
                                   Eigen::Matrix2d& J_z) {
  first_.push_back(landmark(size() - 2));
  plane_placement(first_.back() - turned_about(), z, J_r, J_z);
}

}  // namespace credence::internal
