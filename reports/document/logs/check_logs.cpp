#include "reports/document/logs/check_logs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/parallel_tasks.h"
#include "datasets/data_error.h"
#include "datasets/logs/judge_logs.h"
#include "datasets/logs/log_name.h"
#include "datasets/logs/run_errors.h"
#include "datasets/logs/time_offset.h"
#include "reports/document/judge/judged.h"
#include "reports/document/logs/checked_logs.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

using Formats = std::map<fs::path, const LogFormat*>;

/// An option that only some formats have a use for.
struct FormatOption {
  std::string_view name;
  bool given, taken;
  std::string_view accepted;  ///< the formats
  bool of_truth = true;       ///< says how the log is compared with one
};

bool names_truth(const CheckOptions& o) { return !o.truths.empty() || !o.reading.truth_topic.empty(); }

/// Throws std::invalid_argument for an option that would do nothing.
void require_use(const fs::path& file, const LogFormat& format, const CheckOptions& o) {
  constexpr std::string_view kPoses = "bags and trajectories of poses";
  const LogReadOptions& r = o.reading;
  const TrajectoryMatching& m = r.matching;
  const TrajectoryMatching usual{};
  const bool other_times = m.max_time_difference_s != usual.max_time_difference_s;
  const bool compared = format.has_poses || format.holds_truth;
  const FormatOption options[] = {
      {"--topic", !r.topic.empty(), format.has_topics, "bags", false},
      {"--truth-topic", !r.truth_topic.empty(), format.holds_truth, "bags and PX4 ULog", false},
      {"--instance", r.instance.has_value(), format.has_instances, "PX4 ULog and ArduPilot DataFlash", false},
      {"--chart or --orientation-error", r.chart.has_value(), format.has_poses, kPoses},
      {"--lever-arm", m.lever_arm.has_value(), format.has_poses, kPoses},
      {"--time-offset", m.find_time_offset != usual.find_time_offset || m.time_offset_s, format.has_poses,
       kPoses},
      {"--align", m.alignment != usual.alignment, format.has_poses, kPoses},
      {"--truth-time", m.truth_time != usual.truth_time, compared,
       "bags, trajectories of poses and PX4 ULog"},
      {"--max-time-difference", other_times, compared || format.takes_truth,
       "bags, trajectories of poses, PX4 ULog and RTKLIB"}};
  for (const FormatOption& option : options) {
    if (!option.given) continue;
    if (!option.taken) {
      throw std::invalid_argument(fmt::format("{}: {} is read as {}; accepted are {}", option.name,
                                              file.string(), format.title, option.accepted));
    }
    if (option.of_truth && !names_truth(o)) {
      throw std::invalid_argument(
          fmt::format("{}: does nothing without a truth, and none is named for {} (--truth, --truth-topic)",
                      option.name, file.string()));
    }
  }
}

/// "PX4 ULog, …; truth interpolated, …"
std::string format_text(const CheckOptions& o, const Formats& formats) {
  std::set<std::string_view> titles;
  bool with_truth = false;
  for (const auto& [file, format] : formats) {
    titles.insert(format->title);
    with_truth = with_truth || (format->takes_truth && names_truth(o));
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

/// A sentence without its numbers.
std::string form_of(std::string_view sentence) {
  std::string form;
  for (const char c : sentence) {
    const bool in_number = (c >= '0' && c <= '9') || c == '.';
    if (!in_number) form += c;
    if (in_number && !form.ends_with('0')) form += '0';
  }
  return form;
}

/// The sentences of several files that are of these kinds, the first of those that differ by their numbers
/// alone; with the name of its file, where there are others of which it is not true.
std::vector<std::string> remarks_of(const LogJudgeResult& result,
                                    std::initializer_list<LogRemark::Kind> kinds) {
  struct Told {
    const LogRemark* first;
    std::set<fs::path> files;
    bool same = true;
  };
  std::vector<Told> all;
  std::map<std::string, std::size_t> place;  // of a form
  for (const LogRemark& remark : result.remarks) {
    if (std::ranges::find(kinds, remark.kind) == kinds.end()) continue;
    const auto [found, is_new] = place.try_emplace(form_of(remark.sentence), all.size());
    if (is_new) all.push_back({&remark, {}});
    Told& told = all[found->second];
    told.files.insert(remark.file);
    told.same = told.same && remark.sentence == told.first->sentence;
  }
  std::vector<std::string> texts;
  for (const Told& told : all) {
    const std::string file = told.first->file.string();
    std::string& text = texts.emplace_back(told.first->sentence);
    const auto n = std::ssize(told.files);
    if (told.same && n > 1) {
      text += fmt::format(" ({} files.)", n);
    } else if (result.files > 1 && !file.empty() && text.find(file) == std::string::npos) {
      text = fmt::format("{}: {}", file, text);
      if (n > 1)
        text += fmt::format(" ({} more {} other numbers.)", n - 1, n > 2 ? "files have" : "file has");
    }
  }
  return texts;
}

/// The time offset of all files together, if one is asked for; nothing of one file, whose own it is, and
/// where it was stopped.
std::shared_ptr<const TimeOffset> common_offset(std::span<const fs::path> files, const Formats& formats,
                                                const LogReading& reading, const CheckOptions& options) {
  if (reading.matching.find_time_offset != TimeOffsetSearch::together || files.size() < 2 ||
      !names_truth(options))
    return nullptr;
  std::vector<PosesWithTruth> poses(files.size());
  std::atomic<std::int64_t> read = 0;
  for_each_task(std::ssize(files), options.threads, options.stop, [&](std::int64_t i) {
    const fs::path& file = files[static_cast<std::size_t>(i)];
    poses[static_cast<std::size_t>(i)] = formats.at(file)->poses(file, reading);
    ++read;
  });
  if (read < std::ssize(files)) return nullptr;
  return std::make_shared<const TimeOffset>(find_time_offset(poses, reading.matching, options.threads));
}

/// What tells of the bytes read that they are of these files.
std::function<void(std::int64_t)> told_of_bytes(std::span<const fs::path> files,
                                                const JudgeProgress& progress) {
  if (!progress) return {};
  std::int64_t all = 0;
  for (const fs::path& file : files) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    if (!error) all += static_cast<std::int64_t>(size);
  }
  return [&progress, all](std::int64_t bytes) { progress(bytes, all); };
}

}  // namespace

Formats formats_of(std::span<const fs::path> files, const CheckOptions& o) {
  Formats formats;
  for (const fs::path& file : files) {
    const LogFormat& format = log_format_of(file, o.format);
    if (!o.truths.empty() && !format.takes_truth) {
      format.list(file);  // what is wrong with its header is nearer
      throw std::invalid_argument(fmt::format(
          "--truth: {} is read as {}, which holds its truth itself, or has none{}", file.string(),
          format.title,
          format.name == "credence"
              ? "; columns truth.NAME of another file go beside its own: docs/recipes.md, “Judge a "
                "CSV whose truth is in another file”"
              : ""));
    }
    require_use(file, format, o);
    formats.emplace(file, &format);
  }
  return formats;
}

namespace {

/// Of errors and innovations that are all blank or NaN there is no verdict, and nothing that could fail.
void require_something_to_judge(const CheckedLogs& logs, const fs::path& first) {
  const Evidence& evidence = logs.analysis.evidence;
  const Judgement& judgement = logs.analysis.judgement;
  const bool claimed = evidence.has_truth || !evidence.sensors.empty();
  const bool explained = evidence.rejected_rows() + evidence.wrongly_certain_rows() > 0 ||
                         !evidence.study.failures.empty() || logs.unmatched_rows > 0 ||
                         !logs.analysis.complete;
  const bool judged =
      judgement.nees.count > 0 ||
      std::ranges::any_of(judgement.blocks, [](const BlockVerdict& b) { return b.verdict.count > 0; }) ||
      std::ranges::any_of(judgement.sensors, [](const SensorJudgement& s) { return s.nis.count > 0; });
  if (!claimed || explained || judged) return;
  throw DataError(first, "",
                  fmt::format("there is nothing to judge in {} rows: no row has an error, or an innovation, "
                              "that is a number",
                              evidence.rows));
}

}  // namespace

CheckedLogs checked_logs(std::span<const fs::path> files, const CheckOptions& options, bool keep_first_run) {
  using Kind = LogRemark::Kind;
  const Formats formats = formats_of(files, options);
  LogReading reading{options.reading, {}, {}};
  reading.truth = TruthFiles(files, options.truths);
  reading.common_offset = common_offset(files, formats, reading, options);
  RunErrors first_run;
  const auto read = [&](const fs::path& file, LogSink& sink) {
    FirstRunSink first(sink, first_run);
    const bool kept = keep_first_run && &file == &files.front();  // read by one thread, like every file
    formats.at(file)->read(file, reading, kept ? static_cast<LogSink&>(first) : sink);
  };
  LogJudgeResult result = judge_logs(files, read,
                                     {.threads = options.threads,
                                      .stop = options.stop,
                                      .progress = told_of_bytes(files, options.progress),
                                      .partial = reading.partial});
  CheckedLogs logs;
  if (result.evidence.rows == 0 && !result.complete) {
    logs.analysis.complete = false;
    return logs;
  }
  logs.name = options.name;
  logs.format = format_text(options, formats);
  logs.files = result.files;
  logs.run_names = result.run_names;
  logs.unmatched_rows = result.unmatched_rows;
  logs.remarks = remarks_of(result, {Kind::remark});
  if (!result.copies.says.empty()) logs.remarks.push_back(result.copies.says);
  std::ranges::move(result.judged.sentences(), std::back_inserter(logs.remarks));
  judge_collected(
      std::move(result.evidence), std::move(result.calibration),
      {.confidence = options.confidence,
       .sensitivity = options.sensitivity,
       .margin = options.within,
       .truth_fit = result.truth_fit,
       .times = result.times.known() ? std::make_shared<const StepTimes>(std::move(result.times)) : nullptr,
       .run_names = std::move(result.run_names),
       .copies = result.copies.many() ? std::move(result.copies.says) : std::string()},
      {.said = {.misfits = remarks_of(result, {Kind::misfit}),
                .others = remarks_of(result, {Kind::hint, Kind::mistake})},
       .swapped_axes = result.swapped_axes},
      logs);
  logs.analysis.complete = result.complete;
  require_something_to_judge(logs, files.front());
  logs.poses = std::move(result.poses);
  logs.first_run = std::move(first_run);
  return logs;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

JudgedFilter check_logs(std::span<const std::string> logs, const CheckOptions& options) {
  if (logs.empty()) throw std::invalid_argument("check_logs: no logs were given");
  CheckedLogs checked = checked_logs(log_files(logs), options, true);
  if (checked.analysis.evidence.rows == 0 && !checked.analysis.complete) {
    throw std::runtime_error("interrupted before the first rows were judged");
  }
  if (std::string left_out = files_left_out(logs); !left_out.empty())
    checked.remarks.push_back(std::move(left_out));
  checked.name = options.name.empty() ? log_name(logs.front()) : options.name;
  return JudgedFilter(judged_logs(std::move(checked)));
}

}  // namespace credence
