#pragma once

#include <string_view>

#include "datasets/logs/ros/ros_scan.h"

namespace credence::internal {

/// Whether a file that begins so is an SQLite database.
bool begins_as_sqlite(std::string_view beginning);

/// Reads the messages of a bag of ROS 2 in SQLite (tables `topics` and `messages`) in the order of their
/// times, through libsqlite3. Throws DataError.
void scan_ros2_sqlite(const std::filesystem::path& file, const RosVisitor& visitor);

}  // namespace credence::internal
