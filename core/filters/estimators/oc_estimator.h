#pragma once

#include "core/filters/estimators/fej_estimator.h"

namespace credence {

/// Observability-constrained EKF: Jacobians at the newest estimates, changed as little as keeps the
/// directions that no measurement tells ([Huang 2010] in the idea, [Hesch 2014] in the form that is solved
/// here).
///
/// These directions are a shift of the plane and a turn of it about the points N of the first estimates, as
/// in FejEstimator. Of all Φ with Φ N_k = N_{k+1} that move only the pose there is one, that of FEJ. Of all H
/// with H N = 0 the nearest in Frobenius norm is H* = H − H u uᵀ/(uᵀu), with u = [−J d/2; 1; J d/2],
/// d = l̂₀ − p̂_{k|k−1}: the turn of vehicle and landmark about their middle (m and rad are weighed alike; H
/// itself is blind to shifts).
class OcEstimator final : public FejEstimator {
 public:
  using FejEstimator::FejEstimator;

 private:
  void linearise(const PlanarTruth& truth) override;
};

}  // namespace credence
