#include "datasets/logs/trajectory_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace credence {

TrajectoryJudge::TrajectoryJudge(std::span<const std::filesystem::path> estimates,
                                 const std::vector<std::string>& truths, TrajectoryFormat format,
                                 PoseErrorAxes axes, const TrajectoryMatching& matching)
    : estimates_(estimates.begin(), estimates.end()),
      truths_(truths),
      format_(format),
      axes_(axes),
      matching_(matching) {
  if (truths.size() != 1 && truths.size() != estimates.size()) {
    throw std::invalid_argument(
        fmt::format("--truth: {} files for {} logs; accepted is one for all, or one for each", truths.size(),
                    estimates.size()));
  }
  if (truths.size() == 1) common_truth_ = std::make_shared<const Trajectory>(read_truth(truths.front()));
}

std::shared_ptr<const Trajectory> TrajectoryJudge::truth_of(const std::filesystem::path& estimate) const {
  if (common_truth_) return common_truth_;
  const auto place = std::ranges::find(estimates_, estimate) - estimates_.begin();
  return std::make_shared<const Trajectory>(read_truth(truths_[static_cast<std::size_t>(place)]));
}

LogFileReader TrajectoryJudge::reader() {
  return [this](const std::filesystem::path& file, EvidenceRecorder& sums,
                const std::function<void(std::int64_t)>& advance) {
    const Trajectory estimate = read_estimate(file, format_, axes_);
    const TrajectoryErrors errors = trajectory_errors(estimate, *truth_of(file), matching_);
    sums.begin_file(file, errors.layout);
    sums.begin_run();
    for (const Step& row : errors.rows) sums.add(row);
    unmatched_ += errors.unmatched;
    advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
  };
}

}  // namespace credence
