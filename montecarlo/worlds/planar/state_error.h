#pragma once

#include <span>

#include "core/models/range_bearing.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"
#include "montecarlo/worlds/planar/planar_step.h"

namespace credence::internal {

/// The true state in the order of a filter's: [pose; landmarks by number].
Vector true_state(const Pose& pose, std::span<const Point> landmarks, std::span<const int> order);

/// The error of a planar SLAM estimate and its NEES.
struct StateError {
  Vector error;               ///< x̂ − x, heading wrapped
  double nees = 0.0;          ///< eᵀ P⁻¹ e over the states of non-zero variance
  Index dof = 0;              ///< how many these are
  double vehicle_nees = 0.0;  ///< of the pose block

  /// Computes all of it; `diverged` for an error above 1e4 m, `not_positive_definite` when a Cholesky factor
  /// of P (its zero-variance states left out) does not exist.
  template <PlanarCovariance Covariance>
  Outcome compute(const Pose& pose, std::span<const Point> landmarks, const Vector& x, const Covariance& P,
                  std::span<const int> order) {
    return set_error(pose, landmarks, x, order) ? solve(P) : Outcome::diverged;
  }

  /// The error alone; false for one above 1e4 m.
  bool set_error(const Pose& pose, std::span<const Point> landmarks, const Vector& x,
                 std::span<const int> order);
  /// NEES of the error by a factor of P.
  template <PlanarCovariance Covariance>
  Outcome solve(const Covariance& P) {
    return set_nees(joint_nees(error, P, solver_), pose_nees(error, P, pose_solver_));
  }
  /// NEES that is known of the whole state, and that of the pose.
  Outcome take(const NeesValue& whole, const Eigen::Matrix3d& pose_covariance) {
    return set_nees(whole, pose_nees(error, pose_covariance, pose_solver_));
  }

  /// Of `error` and a dense P; what else it shall solve for is told to it beforehand.
  NeesSolver& solver() { return solver_; }

  /// The numbers that the statistics take.
  void put_into(PlanarStep& step) const;

 private:
  Outcome set_nees(const NeesValue& whole, const NeesValue& vehicle);

  NeesSolver solver_, pose_solver_;  ///< two, so that neither changes its size
};

}  // namespace credence::internal
