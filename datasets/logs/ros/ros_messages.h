#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/ros/ros_scan.h"
#include "datasets/logs/trajectory.h"

/// @file
/// The messages of ROS that hold poses, in the serialisation of ROS 1 and in CDR.

namespace credence::internal {

/// A pose that a message holds.
struct RosPose {
  double time_s = 0.0;      ///< of its header; that of the log where the header has none
  std::string frame;        ///< header.frame_id
  std::string child_frame;  ///< of Odometry and transforms, else ""
  /// NavSatFix: latitude (rad), longitude (rad) and altitude (m) in `position`; NaN without a fix.
  SpatialPose pose;
  bool has_orientation = false;  ///< false also for a quaternion of zeros; `pose` has the identity then
  /// As the message holds it: 6×6, or 3×3 in its upper left corner for NavSatFix.
  std::optional<PoseCovariance> covariance{};
};

/// What a type of message can be used as.
struct RosPoseType {
  std::string_view type;  ///< "nav_msgs/Odometry"
  bool covariance = false;
  bool has_orientation = true;
  bool geodetic = false;
  bool several = false;  ///< a message holds poses of several frames
};

/// nullptr for a type that holds no poses.
const RosPoseType* ros_pose_type(std::string_view type);

/// The poses of a message of such a type. Throws DataError at the byte for a message that ends too early, and
/// for a quaternion that is not of unit length (within 1 %; it is then normalised). All zeros,
/// as a message that nobody filled in has them, are no orientation.
void read_ros_poses(const RosPoseType& type, RosTopic::Encoding encoding, double log_time_s,
                    const ByteCursor& message, std::vector<RosPose>& poses);

}  // namespace credence::internal
