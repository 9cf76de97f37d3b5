#pragma once

#include <optional>
#include <string>

#include "datasets/logs/conventions/pose_chart.h"
#include "datasets/logs/trajectory_errors.h"

namespace credence {

/// What a user can say about logs; each format takes what concerns it.
struct LogReadOptions {
  std::string topic{};               ///< of the estimate; "" where only one fits
  std::string truth_topic{};         ///< of the truth in the same file; "" for none
  std::optional<int> instance{};     ///< of several filters in one log: which one
  std::optional<PoseChart> chart{};  ///< none: what the format means by itself
  TrajectoryMatching matching{};
  /// Of a file that is cut off or corrupted what comes before is read, with a remark, if it is anything.
  bool partial = false;
};

}  // namespace credence
