#pragma once

#include <vector>

#include "core/filters/estimators/slam_estimator.h"

namespace credence::internal {

/// What filters have in common that linearise landmarks where they were put at their first observation.
class FirstLandmarkEstimator : public SlamEstimator {
 public:
  explicit FirstLandmarkEstimator(const EstimatorSettings& settings);

 protected:
  void started() override { first_.clear(); }
  /// l̂₀ of the landmark that starts at this state.
  const Point& first_landmark(Index offset) const { return first_[static_cast<std::size_t>(offset - 3) / 2]; }

 private:
  /// The place of the vehicle about which a turn moves a landmark just seen.
  virtual Point turned_about() const = 0;
  void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r, Eigen::Matrix2d& J_z) final;

  std::vector<Point> first_;  ///< in the order of the state
};

}  // namespace credence::internal
