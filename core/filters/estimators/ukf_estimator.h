#pragma once

#include "core/filters/estimators/slam_estimator.h"
#include "core/filters/estimators/unscented_transform.h"

namespace credence::internal {

/// Unscented Kalman filter ([Julier 2004]) whose errors are x̂ − x, over SO(2) × ℝⁿ⁻¹ as heading differences
/// are wrapped: the SO(2) UKF of [Brossard 2020].
///
/// Sigma points of only those states that a function reads: the pose and the noise of the control to predict,
/// pose and landmarks seen to correct. A = D L⁻¹ takes the place of the Jacobian, so that the other states
/// follow as they would with all n in the sigma points; in directions without variance, where A is free, it
/// is the Jacobian. A landmark is placed by Jacobians.
class UkfEstimator final : public SlamEstimator {
 public:
  using SlamEstimator::SlamEstimator;

 private:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;

  UnscentedTransform motion_, measurement_;
};

}  // namespace credence::internal
