#pragma once

#include <vector>

#include "core/filters/estimators/ekf_estimator.h"

namespace credence::internal {

/// SLAM without correlations, by split covariance intersection ([Julier 2007]): P keeps the blocks of the
/// vehicle and of each landmark alone, O(N) of memory, and makes no claim on what correlates them.
///
/// Of the vehicle's covariance D + I the part I, the noise of its motion since a landmark last told it
/// something, depends on no landmark. Whatever the correlation of vehicle and landmark,
/// diag(D/ω + I, P_l/(1 − ω)) bounds their joint covariance for every ω in (0, 1); one Kalman correction of
/// it by the observation of that landmark gives the bounds P_r⁺ and P_l⁺. Each takes the ω that makes its own
/// variances smallest, as sum of their ratios to those before, and stays as it is where none does. Landmarks
/// of a batch come one after the other, each linearised at the estimates that it finds. A bound, not the
/// Kalman filter, where the world is linear.
class IntersectionEstimator final : public EkfEstimator {
 public:
  using EkfEstimator::EkfEstimator;

 private:
  void started() override {
    independent_.setZero();
    moved_.reserve(static_cast<std::size_t>(settings().landmarks));
  }
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  bool correct(UpdateResult& result) override;
  bool refine(Batch observations, const PlanarTruth& truth) override;

  struct Moved {  ///< a landmark of the batch: where it starts in the state, δ and its P⁺
    Index offset;
    Eigen::Vector2d delta;
    Eigen::Matrix2d P;
  };

  PoseMatrix independent_ = PoseMatrix::Zero();  ///< I
  std::vector<Moved> moved_;                     ///< taken over once the whole batch is sound
};

}  // namespace credence::internal
