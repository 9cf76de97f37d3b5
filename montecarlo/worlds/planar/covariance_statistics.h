#pragma once

#include <concepts>

#include "core/record/nees_solver.h"
#include "core/types.h"

/// @file
/// All that the statistics of a planar filter read of its covariance P. A filter whose covariance is no dense
/// matrix brings its own overloads of these functions, in the namespace of its covariance.

namespace credence {

/// The NEES of the whole state.
inline NeesValue joint_nees(const Vector& error, const Matrix& P, NeesSolver& solver) {
  return solver.solve(error, P);
}

/// The NEES of the first three states, such as a pose in the plane.
NeesValue pose_nees(const Vector& error, const Matrix& P, NeesSolver& solver);

/// Sums of variances.
struct PlanarTraces {
  double all = 0.0;        ///< tr P
  double position = 0.0;   ///< of x and y
  double heading = 0.0;    ///< of the heading
  double landmarks = 0.0;  ///< of the map
};

/// Of the covariance of [x; y; heading; map].
PlanarTraces planar_traces(const Matrix& P);
/// Of its trace and the block of the pose.
PlanarTraces planar_traces(double trace, const Eigen::Matrix3d& pose);

/// P as a matrix, for who looks at a single run.
inline const Matrix& dense_covariance(const Matrix& P) { return P; }

/// A covariance that can be judged.
template <class Covariance>
concept PlanarCovariance = requires(const Covariance& P, const Vector& error, NeesSolver& solver) {
  { joint_nees(error, P, solver) } -> std::same_as<NeesValue>;
  { pose_nees(error, P, solver) } -> std::same_as<NeesValue>;
  { planar_traces(P) } -> std::same_as<PlanarTraces>;
  { dense_covariance(P) } -> std::convertible_to<Matrix>;
};

}  // namespace credence
