#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence {

/// Unscented Kalman filter ([Julier 2004]) whose errors are x̂ − x, over SO(2) × ℝⁿ⁻¹ as heading differences
/// are wrapped: the SO(2) UKF of [Brossard 2020].
///
/// Sigma points x̂ ± √c L_j, L Lᵀ = P, c = α² l, of only those l states that a function reads: the pose and
/// the noise of the control to predict, pose and landmarks seen to correct. With y± = f(x̂ ± √c L_j) − f(x̂),
/// D_j = (y₊ − y₋)/(2√c) and s_j = (y₊ + y₋)/2 the unscented moments, of β = 2, are
///
///   ȳ = f(x̂) + μ,   μ = Σ s_j/c,   cov y = Σ_j (D_j D_jᵀ + s_j s_jᵀ/c) + (β − α²) μ μᵀ,
///
/// a sum of like terms however small α is. A = D L⁻¹ takes the place of the Jacobian, so that the other
/// states follow as they would with all n in the sigma points; in directions without variance, where A is
/// free, it is the Jacobian. A landmark is placed by Jacobians.
class UkfEstimator final : public SlamEstimator {
 public:
  using SlamEstimator::SlamEstimator;

 private:
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void linearise(const PlanarTruth& truth) override;

  MatrixBuffer root_, D_, half_sums_, shift_;
};

}  // namespace credence
