#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "datasets/logs/bytes/byte_cursor.h"

/// @file
/// What the containers of ROS messages have in common: mcap.h, ros1_bag.h, ros2_sqlite.h.

namespace credence::internal {

struct RosTopic {
  std::string name;
  std::string type;  ///< "nav_msgs/Odometry", without the "msg" that ROS 2 puts between
  enum class Encoding { ros1, cdr, other } encoding = Encoding::other;

  bool operator==(const RosTopic&) const = default;
};

/// "nav_msgs/msg/Odometry" is "nav_msgs/Odometry".
inline std::string type_of_ros_1(std::string type) {
  if (const std::size_t msg = type.find("/msg/"); msg != std::string::npos) type.erase(msg, 4);
  return type;
}

struct RosVisitor {
  /// Topics are counted from 0 in the order in which they come; a topic is announced once for each of its
  /// publishers, where the file tells them apart.
  std::function<void(std::size_t topic, const RosTopic&)> topic = [](std::size_t, const RosTopic&) {};
  std::function<void(std::size_t topic, double time_s, const ByteCursor& message)> message;
  std::function<void(std::int64_t bytes)> advance = [](std::int64_t) {};
};

/// Reads a file in one pass, in the order in which messages were written, in memory for one chunk. Throws
/// DataError.
using RosScan = std::function<void(const std::filesystem::path& file, const RosVisitor& visitor)>;

}  // namespace credence::internal
