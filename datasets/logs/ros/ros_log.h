#pragma once

#include "datasets/logs/log_format.h"

/// @file
/// Bags of ROS as formats of logs: a topic of poses with covariance is judged against a topic, or a file, of
/// poses that are taken for the truth.

namespace credence::internal {

LogFormat mcap_format();         ///< --input mcap
LogFormat ros2_sqlite_format();  ///< --input db3
LogFormat ros1_bag_format();     ///< --input rosbag

}  // namespace credence::internal
