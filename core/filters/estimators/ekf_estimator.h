#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence::internal {

/// EKF-SLAM: every Jacobian at the newest estimate. It takes the heading for observable, since its estimates
/// of one state move between Jacobians ([Huang 2010]).
class EkfEstimator : public SlamEstimator {
 public:
  using SlamEstimator::SlamEstimator;

 protected:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
};

}  // namespace credence::internal
