#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/trajectory.h"

namespace credence::internal {

/// The files that hold the truth of logs which do not hold it themselves.
class TruthFiles {
 public:
  TruthFiles() = default;
  /// truths: one file for all logs, or one for each in their order; none is none. Throws
  /// std::invalid_argument for another number of them.
  TruthFiles(std::span<const std::filesystem::path> logs, std::vector<std::string> truths);

  bool empty() const { return truths_.empty(); }

  std::filesystem::path file_of(const std::filesystem::path& log) const;

  /// The truth of one of the logs as a trajectory; one for all is read once. Safe from several threads.
  /// Throws DataError.
  std::shared_ptr<const Trajectory> of(const std::filesystem::path& log) const;

 private:
  std::vector<std::filesystem::path> logs_;
  std::vector<std::string> truths_;

  struct Common {
    std::once_flag read;
    std::shared_ptr<const Trajectory> truth;
  };
  std::shared_ptr<Common> common_ = std::make_shared<Common>();
};

}  // namespace credence::internal
