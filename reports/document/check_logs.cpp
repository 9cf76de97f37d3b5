#include "reports/document/check_logs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/logs/judge_logs.h"
#include "datasets/logs/log_name.h"
#include "datasets/logs/run_errors.h"
#include "reports/document/checked_logs.h"
#include "reports/document/judged.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

using Formats = std::map<fs::path, const LogFormat*>;

bool moves_truth(const TrajectoryMatching& m) { return m.find_time_offset || m.time_offset_s || m.lever_arm; }

/// "PX4 ULog, …; truth interpolated, …"
std::string format_text(const CheckOptions& o, const Formats& formats) {
  std::set<std::string_view> titles;
  bool with_truth = false;
  for (const auto& [file, format] : formats) {
    titles.insert(format->title);
    with_truth = with_truth || (format->takes_truth && (!o.truths.empty() || !o.reading.truth_topic.empty()));
  }
  std::string text = fmt::format("{}", fmt::join(titles, ", "));
  if (with_truth) {
    const TrajectoryMatching& m = o.reading.matching;
    text += fmt::format("; truth {}, at most {:g} s away; alignment of the truth: {}",
                        m.truth_time == TruthTime::nearest ? "nearest" : "interpolated",
                        m.max_time_difference_s, to_string(m.alignment));
  }
  return text;
}

/// The sentences of several files; the same sentence of several only once.
std::vector<std::string> remarks_of(const LogJudgeResult& result) {
  std::vector<std::string> texts;
  std::map<std::string, std::int64_t> times;
  for (const LogRemark& remark : result.remarks) {
    if (times[remark.sentence]++ == 0) texts.push_back(remark.sentence);
  }
  for (std::string& text : texts) {
    if (const std::int64_t n = times[text]; n > 1) text += fmt::format(" ({} files.)", n);
  }
  return texts;
}

}  // namespace

Formats formats_of(std::span<const fs::path> files, const CheckOptions& o) {
  Formats formats;
  for (const fs::path& file : files) {
    const LogFormat& format = log_format_of(file, o.format);
    if (!o.truths.empty() && !format.takes_truth) {
      throw std::invalid_argument(
          fmt::format("--truth: {} is read as {}, which holds its truth itself, or has none", file.string(),
                      format.title));
    }
    if (const TrajectoryMatching& m = o.reading.matching; !format.has_poses && moves_truth(m)) {
      throw std::invalid_argument(
          fmt::format("{}: {} is read as {}; accepted are bags and trajectories of poses",
                      m.lever_arm ? "--lever-arm" : "--time-offset", file.string(), format.title));
    }
    formats.emplace(file, &format);
  }
  return formats;
}

CheckedLogs checked_logs(std::span<const fs::path> files, const CheckOptions& options,
                         const CheckWatch& watch) {
  const Formats formats = formats_of(files, options);
  LogReadOptions reading = options.reading;
  reading.truth = TruthFiles(files, options.truths);
  RunErrors first_run;
  const auto read = [&](const fs::path& file, LogSink& sink) {
    FirstRunSink first(sink, first_run);
    const bool kept = watch.keep_first_run && &file == &files.front();  // read by one thread, like every file
    formats.at(file)->read(file, reading, kept ? static_cast<LogSink&>(first) : sink);
  };
  LogJudgeResult result = judge_logs(files, read,
                                     {.threads = options.threads,
                                      .stop = options.stop,
                                      .progress = watch.progress,
                                      .partial = reading.partial});
  CheckedLogs logs;
  if (result.evidence.rows == 0 && !result.complete) {
    logs.analysis.complete = false;
    return logs;
  }
  logs.name = options.name;
  logs.format = format_text(options, formats);
  logs.files = result.files;
  logs.unmatched_rows = result.unmatched_rows;
  logs.remarks = remarks_of(result);
  logs.analysis = analyse_collected(
      std::move(result.evidence), result.calibration,
      {.confidence = options.confidence, .sensitivity = options.sensitivity, .margin = options.within},
      result.explained());
  logs.analysis.complete = result.complete;
  logs.poses = std::move(result.poses);
  logs.calibration = judge_calibration(result.calibration, options.confidence);
  logs.units = unit_factors(result.calibration);
  logs.first_run = std::move(first_run);
  return logs;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

JudgedFilter check_logs(std::span<const std::string> logs, const CheckOptions& options) {
  if (logs.empty()) throw std::invalid_argument("check_logs: no logs were given");
  CheckedLogs checked = checked_logs(log_files(logs), options, {.keep_first_run = true});
  if (checked.analysis.evidence.rows == 0 && !checked.analysis.complete) {
    throw std::runtime_error("interrupted before the first rows were judged");
  }
  checked.name = options.name.empty() ? log_name(logs.front()) : options.name;
  return JudgedFilter(judged_logs(std::move(checked)));
}

}  // namespace credence
