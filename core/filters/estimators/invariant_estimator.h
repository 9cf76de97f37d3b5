#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence::internal {

/// What a correction by δ does to P, whose chart is about the estimate before it. An invariant filter that
/// is one of the left or of the right differs from the other in this alone: the two errors are
/// log(X̂ X⁻¹) = Ad_X̂ log(X⁻¹ X̂), exactly, whatever the error.
enum class InvariantReset {
  right,  ///< nothing: P stays what it is in the chart of log(X̂ X⁻¹), the right-invariant filter
  left,  ///< P stays what it is in the chart of log(X⁻¹ X̂), so that here P ← Ad_exp(δ) P Ad_exp(δ)ᵀ
  full,  ///< P is moved to the chart about the new estimate, P ← 𝒥(δ) P 𝒥(δ)ᵀ with the left Jacobian of exp:
         ///< the same filter from the left and from the right
};

/// The invariant EKF on SE_{1+N}(2) ([Barrau 2015]; [Zhang 2017] in three dimensions).
///
/// The error is e = log(X̂ X⁻¹) with X the pose and all landmarks as one group element, a correction is
/// X̂ ← exp(δ) X̂. Then Φ = I, H = D R̂ᵀ [−I, 0, I] has no column for the heading, and the directions that no
/// measurement tells are constants: shifts, and the turn of the plane about the origin, whatever the
/// estimates. The noise of the turn rate enters every landmark, P ← P + G Q Gᵀ: O(n²).
class InvariantEstimator : public SlamEstimator {
 public:
  explicit InvariantEstimator(const EstimatorSettings& settings, InvariantReset reset = InvariantReset::right)
      : SlamEstimator(settings), reset_(reset) {}

  ErrorChart chart() const override { return ErrorChart::right_invariant; }
  void error(const PlanarTruth& truth, Eigen::Ref<Vector> error) const override;
  Matrix plane_covariance() const override;
  PoseMatrix plane_pose_covariance() const override;

 protected:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;
  /// What noise of covariance Q_r on the pose, as x̂ − x of it, adds to P: G Q_r Gᵀ, δe_p = δp − J p̂ δθ,
  /// δe_θ = δθ, δe_l = −J l̂ δθ.
  void add_pose_noise(const Pose& pose, const PoseMatrix& Q_r);
  void invariant_jacobian(const Pose& pose, const Point& landmark, Jacobian& H_r, Eigen::Matrix2d& H_l) const;

 private:
  void started() override;
  void retract(const VectorRef& delta) override;
  void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r,
             Eigen::Matrix2d& J_z) override;
  /// P ← T P Tᵀ, T: (ε_φ, ε_i) ↦ (ε_φ, A ε_i + q_i ε_φ), q_i = −J B δ_i.
  void transport(const Eigen::Matrix2d& A, const Eigen::Matrix2d& B, const VectorRef& delta);

  InvariantReset reset_;
  MatrixBuffer G_, q_;
};

}  // namespace credence::internal
