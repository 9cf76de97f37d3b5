#include "datasets/logs/truth_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/append_item.h"

namespace credence::internal {

TruthFiles::TruthFiles(std::span<const std::filesystem::path> logs, std::vector<std::string> truths)
    : logs_(logs.begin(), logs.end()), truths_(std::move(truths)) {
  if (truths_.empty()) return;
  if (truths_.size() != 1 && truths_.size() != logs_.size()) {
    throw std::invalid_argument(fmt::format("--truth: {} for {}; accepted is one for all, or one for each",
                                            counted(truths_.size(), "file"), counted(logs_.size(), "log")));
  }
}

std::filesystem::path TruthFiles::file_of(const std::filesystem::path& log) const {
  if (truths_.size() == 1) return truths_.front();
  return truths_.at(static_cast<std::size_t>(std::ranges::find(logs_, log) - logs_.begin()));
}

std::shared_ptr<const Trajectory> TruthFiles::of(const std::filesystem::path& log) const {
  if (truths_.size() > 1) return std::make_shared<const Trajectory>(read_truth(file_of(log)));
  std::call_once(common_->read,
                 [&] { common_->truth = std::make_shared<const Trajectory>(read_truth(file_of(log))); });
  return common_->truth;
}

}  // namespace credence::internal
