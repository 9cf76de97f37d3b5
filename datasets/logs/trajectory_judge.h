#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "datasets/logs/judge_logs.h"
#include "datasets/logs/trajectory_errors.h"

namespace credence {

/// Trajectories of one format with their truth, as a reader of logs.
class TrajectoryJudge {
 public:
  /// truths: one file for all estimates, or one for each in their order. Reads a single truth at once. Throws
  /// std::invalid_argument for another number of them, and DataError.
  TrajectoryJudge(std::span<const std::filesystem::path> estimates, const std::vector<std::string>& truths,
                  TrajectoryFormat format, PoseErrorAxes axes, const TrajectoryMatching& matching);

  /// For judge_logs; valid as long as this.
  LogFileReader reader();

  std::int64_t unmatched() const { return unmatched_.load(); }

 private:
  std::shared_ptr<const Trajectory> truth_of(const std::filesystem::path& estimate) const;

  std::vector<std::filesystem::path> estimates_;
  std::vector<std::string> truths_;
  std::shared_ptr<const Trajectory> common_truth_;
  TrajectoryFormat format_;
  PoseErrorAxes axes_;
  TrajectoryMatching matching_;
  std::atomic<std::int64_t> unmatched_{0};
};

}  // namespace credence
