#include "app/logged_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "app/run_arrays.h"
#include "core/linear_algebra/mirror.h"
#include "core/manifold/angle.h"
#include "datasets/logs/ros/pose_bag.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/study/run_log.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {
namespace {

constexpr std::string_view kPrefix = "run-", kSuffixes[] = {".csv", ".npz", ".mcap"};

/// The logs of runs from `first` on.
std::vector<std::filesystem::path> logs_in(const std::filesystem::path& directory, std::int64_t first) {
  std::vector<std::filesystem::path> logs;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    const std::string extension = entry.path().extension().string();
    if (!name.starts_with(kPrefix) || std::ranges::find(kSuffixes, extension) == std::end(kSuffixes))
      continue;
    const char* begin = name.data() + kPrefix.size();
    const char* end = name.data() + name.size() - extension.size();
    std::int64_t run = -1;
    const auto [stop, error] = std::from_chars(begin, end, run);
    if (error == std::errc() && stop == end && run >= first) logs.push_back(entry.path());
  }
  return logs;
}

/// The step as its log holds it: the error is the difference of what is written, and of P and S the lower
/// triangle is. In a chart of its own the estimate is written as the truth plus the error there, whose P it
/// is.
Step as_logged(const RunLayout& layout, TraceStep& trace) {
  if (!layout.componentwise) trace.estimate = trace.truth + trace.error;
  Step step = trace;
  step.error = trace.estimate - trace.truth;
  for (Index i = 0; i < step.error.size(); ++i) {
    const auto state = static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)]);
    if (layout.angles[state]) step.error[i] = wrap_angle(step.error[i]);
  }
  mirror_lower(step.P);
  mirror_lower(step.innovations.front().S);
  return step;
}

/// x, y and heading among the states; nothing where the world has no such pose.
std::optional<std::array<Index, 3>> planar_pose(const RunLayout& layout) {
  const auto pose = std::ranges::find(layout.blocks, Part::pose, &Block::part);
  if (pose == layout.blocks.end() || pose->states.size() != 3) return std::nullopt;
  const auto angle = [&](std::size_t i) { return layout.angles[static_cast<std::size_t>(pose->states[i])]; };
  if (angle(0) || angle(1) || !angle(2)) return std::nullopt;
  return std::array<Index, 3>{pose->states[0], pose->states[1], pose->states[2]};
}

/// The pose of a step as a bag holds it; without a time of a step one each second.
LoggedPose logged_pose(const std::array<Index, 3>& pose, const TraceStep& trace, const Step& logged,
                       double step_s) {
  constexpr std::array<Index, 3> kPlanar = {0, 1, 5};
  const auto in_space = [&](const Vector& x) {
    return SpatialPose{{x[pose[0]], x[pose[1]], 0.0},
                       Eigen::Quaterniond(Eigen::AngleAxisd(x[pose[2]], Eigen::Vector3d::UnitZ()))};
  };
  LoggedPose result{.time_s = (step_s > 0.0 ? step_s : 1.0) * static_cast<double>(trace.step),
                    .estimate = in_space(trace.estimate),
                    .truth = in_space(trace.truth)};
  result.P(kPlanar, kPlanar) = logged.P(pose, pose);
  return result;
}

}  // namespace

void discard_logs(const std::filesystem::path& directory, std::int64_t first) {
  for (const std::filesystem::path& file : logs_in(directory, first)) std::filesystem::remove(file);
}

LoggedExperiment::LoggedExperiment(const Experiment& inner, std::filesystem::path directory,
                                   RunLogFormat format, bool fresh, double step_s)
    : ShownExperiment(inner.layout()),
      inner_(inner),
      directory_(std::move(directory)),
      format_(format),
      step_s_(step_s) {
  if (format_ == RunLogFormat::mcap && !planar_pose(layout())) {
    throw ScenarioError(
        "--log-format mcap: this world has no pose in the plane; csv and npz take every world");
  }
  make_directories(directory_);
  held_.emplace(directory_);
  if (fresh) discard_logs(directory_, 0);
  if (!logs_in(directory_, 0).empty()) {
    throw OutputError(
        fmt::format("{}: holds logs of earlier runs; name another folder, or discard them with --fresh",
                    directory_.string()));
  }
}

HeldFolder::~HeldFolder() {
  std::error_code none;
  std::filesystem::remove(file, none);  // before the lock goes, so that it is nobody else's
}

StudyStatistics LoggedExperiment::play(std::int64_t first_run, std::int64_t runs,
                                       ChunkObserver* observer) const {
  std::optional<StudyStatistics> shown;
  if (observer != nullptr) shown = inner_.show_chunk(first_run, runs, *observer);
  StudyStatistics statistics = shown ? std::move(*shown) : inner_.run_chunk(first_run, runs);
  EvidenceRecorder recorder(layout());
  auto failure = statistics.failures.begin();
  for (std::int64_t run = first_run; run < first_run + runs; ++run) {
    const bool failed = failure != statistics.failures.end() && failure->run == run;
    const std::size_t end =
        failed ? static_cast<std::size_t>(failure->step) : std::numeric_limits<std::size_t>::max();
    RunTrace trace = inner_.trace(run);
    std::vector<Step> logged;
    std::vector<LoggedPose> poses;
    for (std::size_t k = 1; k < std::min(end, trace.steps.size()); ++k) {
      logged.push_back(as_logged(layout(), trace.steps[k]));
      if (format_ == RunLogFormat::mcap)
        poses.push_back(logged_pose(*planar_pose(layout()), trace.steps[k], logged.back(), step_s_));
    }
    if (format_ == RunLogFormat::mcap) {
      if (!poses.empty()) write_file(directory_ / fmt::format("run-{:06}.mcap", run), pose_bag_bytes(poses));
    } else if (format_ == RunLogFormat::csv) {
      write_run_log(directory_ / fmt::format("run-{:06}.csv", run), trace, end,
                    failed ? fmt::format("{} at step {}", to_string(failure->outcome), failure->step) : "",
                    step_s_);
    } else if (!logged.empty()) {
      write_file(directory_ / fmt::format("run-{:06}.npz", run), run_arrays(layout(), logged, step_s_));
    }
    recorder.begin_run();
    for (const Step& step : logged) recorder.add(step);
    if (!failed) continue;
    recorder.end_run(failure->outcome, failure->step);
    ++failure;
  }
  StudyStatistics logged = recorder.take().study;
  logged.steps.resize(statistics.steps.size());
  for (std::size_t k = 0; k < statistics.steps.size(); ++k) {
    StepStatistics& step = statistics.steps[k];
    const StepStatistics& from_log = logged.steps[k];
    for (const Quantity q : {Quantity::nees, Quantity::nis, Quantity::vehicle_nees}) step[q] = from_log[q];
    step.nees_dof = from_log.nees_dof;
    step.nis_dof = from_log.nis_dof;
  }
  statistics.nees_of_runs = logged.nees_of_runs;
  statistics.vehicle_nees_of_runs = logged.vehicle_nees_of_runs;
  return statistics;
}

}  // namespace credence::internal
