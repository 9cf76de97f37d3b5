#include "datasets/logs/trajectory_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/data_error.h"
#include "datasets/logs/conventions/convention_check.h"
#include "datasets/logs/conventions/pose_error.h"
#include "datasets/logs/number_field.h"
#include "datasets/logs/partial_read.h"
#include "datasets/logs/pose_columns.h"
#include "datasets/logs/ros/covariance_sentinels.h"
#include "datasets/logs/time_offset.h"
#include "datasets/logs/truth_placement.h"

namespace credence::internal {
namespace {

std::string_view name_of(TrajectoryFormat format) {
  return format == TrajectoryFormat::tum        ? "tum"
         : format == TrajectoryFormat::openvins ? "openvins"
         : format == TrajectoryFormat::poses    ? "poses"
                                                : "cnspy";
}

/// How many numbers the first line that is no comment holds, separated by blanks; 0 if anything else is
/// there.
std::size_t numbers_in_first_row(std::string_view beginning) {
  while (!beginning.empty()) {
    const std::size_t end = beginning.find('\n');
    const std::vector<std::string_view> words = words_between(" \t\r", beginning.substr(0, end));
    beginning.remove_prefix(end == std::string_view::npos ? beginning.size() : end + 1);
    if (words.empty() || words.front().starts_with('#')) continue;
    const auto is_number = [](std::string_view word) { return parse_finite(word).has_value(); };
    return std::ranges::all_of(words, is_number) ? words.size() : 0;
  }
  return 0;
}

/// Whether the user says what the covariance speaks of.
bool takes_charts(TrajectoryFormat format) {
  return format == TrajectoryFormat::tum || format == TrajectoryFormat::poses;
}

/// What the user declared, or the default.
PoseChart chart_of(const LogReading& options, TrajectoryFormat format) {
  if (!options.chart) {
    return pose_chart_of(format == TrajectoryFormat::poses ? OrientationError::world
                                                           : OrientationError::body);
  }
  if (!takes_charts(format) && options.chart->axes.orientation != OrientationError::planar) {
    throw std::invalid_argument(
        fmt::format("--chart: files of --input {} say it themselves; accepted is planar", name_of(format)));
  }
  return *options.chart;
}

/// Moves the estimate to the point on its body whose positions the truth is.
void move_to_point(const SpatialPose& arm, TrajectoryFormat format, Trajectory& estimate) {
  if (!estimate.joint_covariance) {
    throw std::invalid_argument(fmt::format(
        "--lever-arm: with a truth of positions alone the covariance between position and orientation is "
        "needed, which files of --input {} do not hold",
        name_of(format)));
  }
  for (std::size_t i = 0; i < estimate.poses.size(); ++i)
    move_on_body(arm, estimate.axes, estimate.poses[i], estimate.covariances[i]);
}

/// Says where z, roll and pitch have no variance, or that of a message of ROS that does not estimate them.
void tell_planar(const Trajectory& estimate, LogSink& sink) {
  CovarianceSentinels sentinels;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i)
    sentinels.kept(estimate.covariances[i], estimate.poses[i]);
  if (!sentinels.planar()) return;
  sink.mistake(
      "The variances of z and of the rotations about x and y are 0 or at least 1e5 in every row, as of a "
      "pose in the plane: judge it by --chart planar.");
}

/// A file and its truth, before anything is fitted.
struct ReadTrajectory {
  Trajectory estimate;
  PosesWithTruth poses;
  PoseChart chart;
};

ReadTrajectory read_with_truth(const std::filesystem::path& file, TrajectoryFormat format,
                               const LogReading& options, LogSink& sink) {
  if (options.truth.empty()) {
    throw std::invalid_argument(
        fmt::format("{}: a trajectory ({}) has no truth in it: name the truth by --truth", file.string(),
                    name_of(format)));
  }
  const PoseChart chart = chart_of(options, format);
  Trajectory estimate;
  read_part(
      options, sink, [&] { estimate = read_estimate(file, format, chart.axes, &estimate); },
      [&] { return !estimate.poses.empty(); });
  if (options.chart || takes_charts(format)) {
    estimate.axes = chart.axes;
    for (PoseCovariance& P : estimate.covariances) P = chart.position_first(P);
  }
  if (takes_charts(format) && chart.axes.orientation != OrientationError::planar) tell_planar(estimate, sink);
  const std::shared_ptr<const Trajectory> truth = options.truth.of(file);
  if (options.matching.lever_arm && !truth->has_orientation)
    move_to_point(*options.matching.lever_arm, format, estimate);
  PosesWithTruth poses{pose_samples(estimate, options.matching), truth, estimate.axes,
                       estimate.joint_covariance};
  return {std::move(estimate), std::move(poses), chart};
}

void read_trajectory(const std::filesystem::path& file, TrajectoryFormat format, const LogReading& options,
                     LogSink& sink) {
  const auto [estimate, poses, chart] = read_with_truth(file, format, options, sink);
  const TrajectoryMatching matching = with_time_offset(poses, options, sink);
  ConventionCheck conventions(chart, options.chart.has_value());
  const TrajectoryErrors errors = trajectory_errors(estimate, *poses.truth, matching,
                                                    takes_charts(format) ? &conventions : nullptr, &sink);
  tell_placement(errors.placement, errors.used_up, sink);
  sink.begin_run(errors.layout);
  for (std::size_t i = 0; i < errors.rows.size(); ++i) {
    sink.travelled(errors.travelled_m[i]);
    sink.at(errors.time_s[i]);
    sink.add(errors.rows[i]);
  }
  tell_unmatched(errors.unmatched, std::ssize(estimate.poses), estimate.time_s.front(),
                 estimate.time_s.back(), *poses.truth, matching, sink);
  if (const std::string unit = no_seconds(estimate.time_s.back()); !unit.empty())
    sink.remark(fmt::format("The unit of time: {}.", unit));
  sink.unmatched(errors.between_truths);
  sink.advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
}

LogContents contents_of(const Trajectory& t, std::string type, bool is_truth) {
  const auto count = std::ssize(t.time_s);
  return {.topics = {{.name = t.has_orientation ? "poses" : "positions",
                      .type = std::move(type),
                      .count = count,
                      .rate_hz = message_rate(count, t.time_s.front(), t.time_s.back()),
                      .use = is_truth ? "truth" : "estimate",
                      .covariance = !t.covariances.empty()}},
          .remark = is_truth ? "It is no log, but a truth, which is to be named by --truth."
                             : "The truth is to be named by --truth."};
}

LogContents list_trajectory(const std::filesystem::path& file, TrajectoryFormat format) {
  std::string type(name_of(format));
  try {
    return contents_of(read_estimate(file, format, {}), type, false);
  } catch (const DataError&) {
    try {
      return contents_of(read_truth(file), type, true);
    } catch (const DataError&) {
    }
    throw;  // of the estimate that it is not
  }
}

LogFormat format_of(TrajectoryFormat format, std::string_view title, std::string_view extensions,
                    bool (*recognises)(std::string_view)) {
  return {.name = name_of(format),
          .title = title,
          .extensions = extensions,
          .takes_truth = true,
          .has_poses = true,
          .recognises = [recognises](std::string_view beginning,
                                     const std::filesystem::path&) { return recognises(beginning); },
          .list = [format](const std::filesystem::path& file) { return list_trajectory(file, format); },
          .poses =
              [format](const std::filesystem::path& file, const LogReading& options) {
                SilentSink sink;
                return read_with_truth(file, format, options, sink).poses;
              },
          .read = [format](const std::filesystem::path& file, const LogReading& options,
                           LogSink& sink) { read_trajectory(file, format, options, sink); }};
}

}  // namespace

LogFormat tum_format() {
  return format_of(TrajectoryFormat::tum, "TUM trajectory with covariance", ".tum",
                   [](std::string_view beginning) {
                     // Poses alone are read as this, too, for the message that says what is missing.
                     const std::size_t columns = numbers_in_first_row(beginning);
                     return columns == 29 || columns == 8;
                   });
}

LogFormat pose_csv_format() {
  return format_of(TrajectoryFormat::poses, "CSV of poses with covariance", "",
                   [](std::string_view beginning) {
                     const std::string_view line = beginning.substr(0, beginning.find('\n'));
                     const bool own = line.find("estimate.") != std::string_view::npos ||
                                      line.find("error.") != std::string_view::npos ||
                                      line.find("innovation.") != std::string_view::npos;
                     return !own && csv_pose_columns(line, true).has_value();
                   });
}

LogFormat openvins_format() {
  return format_of(TrajectoryFormat::openvins, "OpenVINS trajectory with covariances", "",
                   [](std::string_view beginning) { return numbers_in_first_row(beginning) == 20; });
}

LogFormat cnspy_format() {
  return format_of(TrajectoryFormat::cnspy, "CSV of PosOrientWithCov", "", [](std::string_view beginning) {
    const std::string_view header = beginning.substr(0, beginning.find('\n'));
    return header.find("pxx") != std::string_view::npos && header.find("qyy") != std::string_view::npos;
  });
}

}  // namespace credence::internal
