#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence::internal {

/// The ideal EKF ([Huang 2010]): its estimates are those of an EKF, every Jacobian is at the
/// truth. No filter that could be built: it shows what of an inconsistency is linearisation.
class IdealEstimator final : public SlamEstimator {
 public:
  using SlamEstimator::SlamEstimator;

 private:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
  void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r,
             Eigen::Matrix2d& J_z) override;
};

}  // namespace credence::internal
