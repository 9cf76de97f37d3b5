#pragma once

#include <span>

#include "datasets/logs/trajectory.h"

/// @file
/// The errors of a pose that covariances speak of, and how a covariance of one kind becomes one of another.

namespace credence::internal {

using PoseError = Eigen::Matrix<double, 6, 1>;  ///< position, then orientation; m, RotationUnit

/// ROS: position in the world, rotation about the fixed axes.
inline constexpr PoseErrorAxes kFixedAxes{.orientation = OrientationError::world};

/// The components of an error that a covariance of it is of, ascending: x, y and yaw in the plane, else all.
std::span<const Index> estimated_components(PoseErrorAxes axes);

/// The rotation vector of R (rad), R = Exp(·), of length at most π.
Eigen::Vector3d rotation_log(const Eigen::Quaterniond& R);

/// Roll, pitch and yaw (rad) of R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d roll_pitch_yaw(const Eigen::Quaterniond& R);

/// x̂ ⊟ x of two poses: position (m), then orientation in the unit of these axes, rad where that is vector;
/// planar: as rpy. Of a quaternion part the one with w ≥ 0.
PoseError pose_error(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes axes);

/// D of pose_error(x̂, x ⊕ δ) = pose_error(x̂, x) + D δ to first order in δ, x ⊕ δ = x Exp(δ) on SE(3).
/// Singular for a pitch of ±90° in rpy.
PoseCovariance pose_error_jacobian(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes axes);

/// D of pose_error(x̂, x') = pose_error(x̂, x) + D w to first order in w, x' the truth x moved with its frame
/// by Exp(w) on SE(3) about the point `centre` of the world.
PoseCovariance frame_jacobian(const SpatialPose& estimate, const SpatialPose& truth,
                              const Eigen::Vector3d& centre, PoseErrorAxes axes);

/// J of e' = e'_0 + J (e − e_0), where e and e' are the errors of the same two poses in the axes `from` and
/// `to`: the adjoint and the Jacobians of SE(3) at the error ([Sola 2018], section 4). The estimate is held.
PoseCovariance error_change(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes from,
                            PoseErrorAxes to);

/// The covariance P of errors about `pose` in other axes, for an error that is not known: error_change at 0.
PoseCovariance transported(const PoseCovariance& P, const SpatialPose& pose, PoseErrorAxes from,
                           PoseErrorAxes to);

/// T ← T A, the pose of another frame on the same body, A its place there: P of errors in these axes goes
/// with it. Errors to the right of T become Ad(A⁻¹) times as large, which is exact.
void move_on_body(const SpatialPose& A, PoseErrorAxes axes, SpatialPose& pose, PoseCovariance& P);

/// The world in the body.
SpatialPose inverse(const SpatialPose& pose);

}  // namespace credence::internal
