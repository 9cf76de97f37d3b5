#pragma once

#include "core/filters/estimators/invariant_estimator.h"

namespace credence::internal {

/// Unscented Kalman filter on SE_{1+N}(2): the right and the left SE(2) UKF of [Brossard 2020], whose error
/// is log(X̂ X⁻¹), or log(X⁻¹ X̂) (InvariantReset).
///
/// The noise of the control goes through sigma points of exp; the motion itself is a product of the group, so
/// that theirs of the state would give it exactly. The mean is moved by the control alone, as there. A
/// measurement takes sigma points of the pose and the landmarks that are seen.
class UkfManifoldEstimator final : public InvariantEstimator {
 public:
  using InvariantEstimator::InvariantEstimator;

 private:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;

  UnscentedTransform noise_, measurement_;
};

}  // namespace credence::internal
