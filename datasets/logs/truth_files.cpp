#include "datasets/logs/truth_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace credence {

TruthFiles::TruthFiles(std::span<const std::filesystem::path> logs, std::vector<std::string> truths)
    : logs_(logs.begin(), logs.end()), truths_(std::move(truths)) {
  if (truths_.empty()) return;
  if (truths_.size() != 1 && truths_.size() != logs_.size()) {
    throw std::invalid_argument(
        fmt::format("--truth: {} files for {} logs; accepted is one for all, or one for each", truths_.size(),
                    logs_.size()));
  }
  if (truths_.size() == 1) common_ = std::make_shared<const Trajectory>(read_truth(truths_.front()));
}

std::shared_ptr<const Trajectory> TruthFiles::of(const std::filesystem::path& log) const {
  if (common_) return common_;
  const auto place = std::ranges::find(logs_, log) - logs_.begin();
  return std::make_shared<const Trajectory>(read_truth(truths_.at(static_cast<std::size_t>(place))));
}

}  // namespace credence
