#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence {

/// The right-invariant EKF on SE_{1+N}(2) ([Barrau 2015]; [Zhang 2017] in three dimensions).
///
/// The error is e = log(X̂ X⁻¹) with X the pose and all landmarks as one group element, a correction is
/// X̂ ← exp(δ) X̂. Then Φ = I, H = D R̂ᵀ [−I, 0, I] has no column for the heading, and the directions that no
/// measurement tells are constants: shifts, and the turn of the plane about the origin, whatever the
/// estimates. The noise of the turn rate enters every landmark, P ← P + G Q Gᵀ: O(n²).
class InvariantEstimator final : public SlamEstimator {
 public:
  using SlamEstimator::SlamEstimator;

  ErrorChart chart() const override { return ErrorChart::right_invariant; }
  void error(const PlanarTruth& truth, Eigen::Ref<Vector> error) const override;
  PoseMatrix plane_pose_covariance() const override;

 private:
  void started() override;
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
  void retract(const VectorRef& delta) override;
  void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r,
             Eigen::Matrix2d& J_z) override;

  MatrixBuffer G_;
};

}  // namespace credence
