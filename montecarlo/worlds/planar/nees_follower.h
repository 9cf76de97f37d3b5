#pragma once

#include <optional>

#include "core/filters/ekf_slam.h"
#include "core/filters/nees_along_run.h"
#include "montecarlo/worlds/planar/planar_normaliser.h"

namespace credence::internal {

/// NEES of an EkfSlam along a run by NeesAlongRun, checked wherever P is factored.
///
/// It has no value where the filter inflates P, where R or the pose given the map is singular, and from the
/// check on in which the two differ by more than kMostNeesDifference or P has a pivot that rounding has
/// eaten: the caller then factors P at every step.
class NeesFollower {
 public:
  /// Follows `filter`, which must live as long.
  explicit NeesFollower(const EkfSlam<PlanarModel>& filter);

  /// Starts a run with the covariance P of the pose.
  void start(const Eigen::Matrix3d& P);
  /// The error of the pose that the filter has predicted.
  Pose prior(const Pose& truth) const;
  /// The filter's step: `prior` is the error of the pose as predicted, `error` that of the state now.
  void step(const Pose& prior, const Vector& error);
  /// Compares with eᵀ P⁻¹ e by a factor of P, which is the last of `solver`.
  void check(const NeesValue& by_factor, const NeesSolver& solver);

  /// Whether there is a value.
  bool has_value() const { return has_value_; }
  NeesValue nees() const { return {nees_, dof_}; }  ///< of all states
  /// What else it tells, where there is a value.
  JointNormalised joint() const {
    return {.whole = nees(), .log_determinant = along_->log_determinant(), .map_nees = along_->map_nees()};
  }

 private:
  const EkfSlam<PlanarModel>& filter_;
  std::optional<NeesAlongRun<PlanarModel>> along_;  ///< none: what this filter does cannot be followed
  bool trusted_ = false, has_value_ = false;
  double nees_ = 0.0;
  Index dof_ = 0;
};

/// For a filter that is not followed.
struct NoFollower {
  template <class F>
  explicit NoFollower(const F&) {}
};

}  // namespace credence::internal
