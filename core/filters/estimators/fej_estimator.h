#pragma once

#include <vector>

#include "core/filters/estimators/slam_estimator.h"

namespace credence {

/// First-estimates-Jacobian EKF ([Huang 2008]): a Jacobian takes the first estimate that there was of each
/// state, the predicted pose and the place where a landmark was put at its first sight, so that the stack of
/// all H_k Φ_k loses the rank that it loses at the truth.
///
///   Φ_k = [I, J(p̂_{k+1|k} − p̂_{k|k−1}); 0, 1],   H = D Rᵀ(θ̂_{k|k−1}) [−I, −J(l̂₀ − p̂_{k|k−1}), I].
///
/// Poor first estimates are its known weakness.
class FejEstimator final : public SlamEstimator {
 public:
  explicit FejEstimator(const EstimatorSettings& settings);

 private:
  void started() override;
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
  void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r,
             Eigen::Matrix2d& J_z) override;

  const Point& first_landmark(Index offset) const { return first_[static_cast<std::size_t>(offset - 3) / 2]; }

  Pose first_pose_ = Pose::Zero();  ///< x̂_{r,k|k−1}
  std::vector<Point> first_;        ///< l̂₀ of the landmarks in the order of the state
};

}  // namespace credence
