#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/trajectory.h"

namespace credence {

/// The files that hold the truth of logs which do not hold it themselves.
class TruthFiles {
 public:
  TruthFiles() = default;
  /// truths: one file for all logs, or one for each in their order; none is none. Reads a single truth at
  /// once. Throws std::invalid_argument for another number of them, and DataError.
  TruthFiles(std::span<const std::filesystem::path> logs, std::vector<std::string> truths);

  bool empty() const { return truths_.empty(); }

  /// The truth of one of the logs; safe from several threads.
  std::shared_ptr<const Trajectory> of(const std::filesystem::path& log) const;

 private:
  std::vector<std::filesystem::path> logs_;
  std::vector<std::string> truths_;
  std::shared_ptr<const Trajectory> common_;
};

}  // namespace credence
