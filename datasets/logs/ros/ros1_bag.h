#pragma once

#include <string_view>

#include "datasets/logs/ros/ros_scan.h"

namespace credence::internal {

/// Whether a file that begins so is a bag of ROS 1, version 2.0.
bool begins_as_ros1_bag(std::string_view beginning);

/// Reads the messages of a bag of ROS 1 (wiki.ros.org/Bags/Format/2.0) without its index, so that a bag that
/// was never closed is read too: in chunks that are not packed or packed with bz2 or lz4, or outside chunks.
/// Throws DataError with the byte for all else.
void scan_ros1_bag(const std::filesystem::path& file, const RosVisitor& visitor);

}  // namespace credence::internal
