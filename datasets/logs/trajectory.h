#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/types.h"

/// @file
/// Trajectories of poses in space as other programs write them (docs/formats.md).

namespace credence {

/// Position and orientation of a body in the world.
struct SpatialPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< takes the body to the world
};

}  // namespace credence

namespace credence::internal {

/// What the orientation's part of a covariance speaks of.
enum class OrientationError {
  body,    ///< R = R̂ Exp(e)
  world,   ///< R = Exp(e) R̂: the fixed axes of ROS
  rpy,     ///< differences of roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll)
  planar,  ///< of the yaw alone; of the position x and y
};

/// What the position's part of a covariance speaks of.
enum class PositionError {
  world,  ///< p = p̂ + e
  body,   ///< p = p̂ + R̂ e
  twist,  ///< with the orientation on SE(3): T = T̂ Exp(e) where that is of the body, T = Exp(e) T̂ of the
          ///< world
};

/// In which numbers a rotation e of OrientationError body and world is written.
enum class RotationUnit {
  vector,           ///< e itself, rad
  half_vector,      ///< e / 2
  quaternion_part,  ///< sin(|e|/2) e/|e|, the vector part of a quaternion
};

/// Of which errors a covariance speaks: x̂ ⊟ x of a pose, position first.
struct PoseErrorAxes {
  PositionError position = PositionError::world;
  OrientationError orientation = OrientationError::body;
  RotationUnit unit = RotationUnit::vector;

  bool operator==(const PoseErrorAxes&) const = default;
};

using PoseCovariance = Eigen::Matrix<double, 6, 6>;  ///< position, then orientation; m, rad unless told

/// Poses in order of time.
struct Trajectory {
  std::filesystem::path file;
  std::vector<double> time_s;  ///< strictly increasing
  std::vector<std::int64_t> lines;
  std::vector<SpatialPose> poses;
  std::vector<PoseCovariance> covariances{};  ///< empty: not known, and of a truth then taken as zero
  bool joint_covariance = true;  ///< false: those between position and orientation are not in the file
  bool has_orientation = true;   ///< false: positions alone
  PoseErrorAxes axes;
};

/// Formats of estimates with a covariance.
enum class TrajectoryFormat {
  tum,       ///< t x y z qx qy qz qw and the upper triangle of the 6×6 covariance, position first
  openvins,  ///< t x y z qx qy qz qw, upper triangles of orientation and of position
  cnspy,     ///< CSV with the header of PosOrientWithCov
  poses,     ///< CSV of poses and 6×6 covariances, position first (pose_columns.h)
};

/// Reads an estimate. tum, poses: `axes` as given; the other formats say it themselves. Throws DataError with
/// file and line for a row of another length, a field that is no finite number, a quaternion that is not of
/// unit length (within 1 %; it is then normalised), times that do not increase, or a file without rows; the
/// rows before it are then in `part`.
Trajectory read_estimate(const std::filesystem::path& file, TrajectoryFormat format, PoseErrorAxes axes,
                         Trajectory* part = nullptr);

/// Reads a truth, whose kind is seen from its content: columns t x y z qx qy qz qw (TUM; further ones are not
/// read), EuRoC CSV (nanoseconds, the scalar of the quaternion first), CSV (pose_columns.h), or positions
/// alone, t x y z. Errors as read_estimate.
Trajectory read_truth(const std::filesystem::path& file);

}  // namespace credence::internal
