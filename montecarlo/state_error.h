#pragma once

#include <Eigen/Cholesky>
#include <span>
#include <vector>

#include "core/range_bearing.h"
#include "montecarlo/study_statistics.h"

namespace credence {

/// The true state in the order of a filter's: [pose; landmarks by number].
Vector true_state(const Pose& pose, std::span<const Point> landmarks, std::span<const int> order);

/// A NEES with its dof.
struct NeesValue {
  double value = 0.0;
  Index dof = -1;  ///< −1: P, its zero-variance states left out, has no Cholesky factor
};

/// eᵀ P⁻¹ e over the states whose variance is not zero; reads the lower triangle of P.
class NeesSolver {
 public:
  NeesValue solve(const Vector& error, const Matrix& P);

  const Vector& whitened() const { return whitened_; }       ///< L⁻¹ e of the last solve
  const Eigen::LLT<Matrix>& factor() const { return llt_; }  ///< L of the last solve

 private:
  Eigen::LLT<Matrix> llt_;
  Vector whitened_;
};

/// NeesSolver for three states, such as a pose in the plane.
NeesValue pose_nees(const Vector& error, const Matrix& P, NeesSolver& solver);

/// The error of a planar SLAM estimate and its NEES.
struct StateError {
  Vector error;               ///< x̂ − x, heading wrapped
  double nees = 0.0;          ///< eᵀ P⁻¹ e over the states of non-zero variance
  Index dof = 0;              ///< how many these are
  double vehicle_nees = 0.0;  ///< of the pose block

  /// Computes all of it; `diverged` for an error above 1e4 m, `not_positive_definite` when a Cholesky factor
  /// of P (its zero-variance states left out) does not exist.
  Outcome compute(const Pose& pose, std::span<const Point> landmarks, const Vector& x, const Matrix& P,
                  std::span<const int> order);

 private:
  NeesSolver solver_;
};

}  // namespace credence
