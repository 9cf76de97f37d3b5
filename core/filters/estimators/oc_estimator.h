#pragma once

#include "core/filters/estimators/first_landmark_estimator.h"

namespace credence::internal {

/// Observability-constrained EKF ([Huang 2010], OC-EKF): the points at which a step linearises are the
/// nearest to the newest estimates that keep the stack of all H_k Φ_k blind for a shift and a turn of the
/// plane.
///
/// Let the turn be [J n; 1; J l̂₀ …], l̂₀ the places where landmarks were put at their first observation. Φ_k
/// with its pose before at p* takes n to n + p̂_{k+1|k} − p*, and H at the landmarks l* is blind for it where
/// l* − p̂_{k+1|k} = l̂₀ − n_{k+1}, so that l* = l̂₀ − n_k + p*. The p* of least
/// ‖p* − p̂_{k|k}‖² + Σ ‖l* − l̂‖², over the landmarks that are seen, is the mean of p̂_{k|k} and of all
/// l̂ − l̂₀ + n_k. The step has been predicted with p* = p̂_{k|k} when they are seen; P is corrected then, by
/// the first batch after a motion.
class OcEstimator final : public FirstLandmarkEstimator {
 public:
  using FirstLandmarkEstimator::FirstLandmarkEstimator;

 private:
  void started() override;
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  void choose_motion();
  void linearise(const PlanarTruth& truth) override;
  Point turned_about() const override { return turn_; }

  bool moves_ = false;                               ///< the motion is still to be chosen
  Point turn_ = Point::Zero();                       ///< n
  Point before_ = Point::Zero();                     ///< p̂_{k|k} of the step that is predicted
  Point moved_ = Point::Zero();                      ///< p̂_{k+1|k} − p̂_{k|k}
  Eigen::Matrix3d noise_ = Eigen::Matrix3d::Zero();  ///< G Q Gᵀ of that step
};

}  // namespace credence::internal
