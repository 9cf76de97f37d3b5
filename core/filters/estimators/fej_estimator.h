#pragma once

#include "core/filters/estimators/first_landmark_estimator.h"

namespace credence::internal {

/// First-estimates-Jacobian EKF ([Huang 2008]): a Jacobian takes the first estimate that there was of each
/// state, the predicted pose and the place where a landmark was put at its first observation, so that the
/// stack of all H_k Φ_k loses the rank that it loses at the truth.
///
///   Φ_k = [I, J(p̂_{k+1|k} − p̂_{k|k−1}); 0, 1],   H = D Rᵀ(θ̂_{k|k−1}) [−I, −J(l̂₀ − p̂_{k|k−1}), I].
///
/// Poor first estimates are its known weakness.
class FejEstimator final : public FirstLandmarkEstimator {
 public:
  using FirstLandmarkEstimator::FirstLandmarkEstimator;

 private:
  void started() override;
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
  Point turned_about() const override { return first_pose_.head<2>(); }

  Pose first_pose_ = Pose::Zero();  ///< x̂_{r,k|k−1}
};

}  // namespace credence::internal
