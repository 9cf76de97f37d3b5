#pragma once

#include <span>
#include <string>

#include "datasets/logs/trajectory.h"

namespace credence::internal {

/// What an estimator says at a time, and what is true.
struct LoggedPose {
  double time_s = 0.0;  ///< not before 1970
  SpatialPose estimate;
  PoseCovariance P = PoseCovariance::Zero();  ///< position, rotation about the fixed axes; 0: not estimated
  SpatialPose truth;
};

inline constexpr const char* kPoseBagEstimate = "/estimate";
inline constexpr const char* kPoseBagTruth = "/truth";

/// The bytes of a bag of ROS 2 in MCAP (mcap.dev/spec), not packed, without an index: the topics /estimate of
/// geometry_msgs/PoseWithCovarianceStamped and /truth of geometry_msgs/PoseStamped in CDR, with their
/// schemas. Times are rounded to a nanosecond.
std::string pose_bag_bytes(std::span<const LoggedPose> poses);

}  // namespace credence::internal
