#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/standard_input.h"
#include "app/study_runner.h"
#include "app/tell.h"
#include "core/append_item.h"
#include "core/large_pages.h"
#include "datasets/logs/log_format.h"
#include "datasets/logs/log_name.h"
#include "datasets/logs/number_field.h"
#include "reports/document/logs/checked_logs.h"
#include "reports/document/logs/log_contents_report.h"
#include "reports/document/logs/log_gate.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

struct CheckArguments : CommonOptions {
  std::vector<std::string> logs;
  CheckOptions how;
  bool list = false, pool = false;
  std::string orientation_error, chart, truth_time = "interpolated", align = "none";
  std::string time_offset, lever_arm;
  std::string baseline, junit, markdown;
};

std::optional<PoseChart> declared_chart(const CheckArguments& o) {
  if (!o.chart.empty()) return pose_chart_named(o.chart);
  const std::string& name = o.orientation_error;
  if (name.empty()) return std::nullopt;
  return pose_chart_named(name == "world" ? "ros" : name);
}

/// How it is to be found, if it is.
TimeOffsetSearch time_offset_search(const std::string& word) {
  if (word == "estimate") return TimeOffsetSearch::together;
  return word == "each" ? TimeOffsetSearch::each : TimeOffsetSearch::none;
}

/// Seconds, where it is not to be found.
std::optional<double> named_time_offset(const CheckArguments& o) {
  if (o.time_offset.empty() || time_offset_search(o.time_offset) != TimeOffsetSearch::none)
    return std::nullopt;
  const std::optional<double> seconds = parse_finite(o.time_offset);
  if (!seconds)
    throw std::invalid_argument(
        fmt::format("--time-offset {}: accepted are estimate, each, or seconds", o.time_offset));
  return seconds;
}

std::vector<double> numbers_of(const std::string& list) {
  std::vector<double> numbers;
  for (const std::string_view field : comma_fields(list))
    numbers.push_back(parse_finite(field).value_or(kNaN));
  return numbers;
}

/// What the words of the command line mean.
CheckOptions options_of(const CheckArguments& o) {
  CheckOptions how = o.how;
  how.name = log_name(o.logs.front());
  how.threads = o.threads;
  how.stop = &catch_interrupt();
  how.reading.chart = declared_chart(o);
  TrajectoryMatching& matching = how.reading.matching;
  matching.truth_time = o.truth_time == "nearest" ? TruthTime::nearest : TruthTime::interpolated;
  matching.alignment = truth_alignment_named(o.align);
  matching.time_offset_s = named_time_offset(o);
  matching.find_time_offset = time_offset_search(o.time_offset);
  if (!o.lever_arm.empty()) matching.lever_arm = lever_arm_of(numbers_of(o.lever_arm));
  return how;
}

// `input`, if any, is done with before anything is printed: who reads that may have gone.

int list(const CheckArguments& o, std::optional<StandardInputFile>& input) {
  const std::vector<fs::path> files = log_files(o.logs);
  const auto formats = formats_of(files, options_of(o));
  std::vector<ListedLog> listed;
  for (const fs::path& file : files) {
    const LogFormat& format = *formats.at(file);
    listed.push_back({file.string(), std::string(format.title), format.list(file)});
  }
  input.reset();
  print(contents_document(std::move(listed)), o);
  return kDone;
}

CheckedLogs judge(const CheckArguments& options, const std::vector<fs::path>& files) {
  constexpr std::int64_t kMegabyte = 1'000'000;
  ProgressDisplay display("check", options.quiet, "MB");
  CheckOptions how = options_of(options);
  if (files.size() == 1) use_one_heap();  // one thread reads, and one adds up
  how.progress = [&](std::int64_t bytes, std::int64_t all) {
    display.show({.runs_done = bytes / kMegabyte, .runs_total = all / kMegabyte + 1});
  };
  return checked_logs(files, how, !options.out.empty());
}

/// Runs of two filters have no verdict in common: that several logs are of one filter, the user must say. A
/// folder says it, too.
void require_one_filter(const CheckArguments& options) {
  if (options.logs.size() < 2 || options.pool) return;
  throw std::invalid_argument(
      fmt::format("check: {} logs: --pool judges them together, as runs of one filter; those of two filters "
                  "want a check --format json each, whose documents credence compare sets side by side",
                  options.logs.size()));
}

/// What is written must not lie on what is read, nor on another output.
void require_own_outputs(const CheckArguments& o, const std::vector<fs::path>& files) {
  const auto place = [](const fs::path& file) {
    std::error_code error;
    return fs::weakly_canonical(fs::absolute(file, error), error);
  };
  std::vector<std::pair<std::string, fs::path>> taken;
  taken.reserve(files.size() + o.how.truths.size() + 3);
  for (const fs::path& file : files) taken.emplace_back("a log that is judged", file);
  for (const std::string& truth : o.how.truths) taken.emplace_back("a truth", truth);
  if (!o.baseline.empty()) taken.emplace_back("the file of --baseline", o.baseline);
  for (const auto& [option, file] : {std::pair{"--junit", o.junit}, std::pair{"--markdown", o.markdown}}) {
    if (file.empty()) continue;
    for (const auto& [what, path] : taken) {
      if (place(file) != place(path)) continue;
      throw std::invalid_argument(fmt::format("{} {}: is {}; name another file", option, file, what));
    }
    taken.emplace_back(fmt::format("the file of {}", option), file);
  }
  for (const std::string& log : o.logs) {
    if (o.out.empty() || !fs::is_directory(log) || place(log) != place(o.out)) continue;
    throw std::invalid_argument(
        fmt::format("--out {}: is a folder of logs, of which the files of the report would be some; name "
                    "another folder",
                    o.out));
  }
}

int interrupted_early() {
  say("credence: interrupted before the first rows were judged");
  return kInterrupted;
}

int check(const CheckArguments& options, std::optional<StandardInputFile>& input) {
  const auto begin = std::chrono::steady_clock::now();
  require_one_filter(options);
  const std::vector<fs::path> files = log_files(options.logs);
  require_own_outputs(options, files);
  const std::string baseline =
      options.baseline.empty()
          ? ""
          : text_of_file(options.baseline,
                         fmt::format("--baseline {}: there is no such file", options.baseline));
  CheckedLogs logs = judge(options, files);
  if (std::string left_out = files_left_out(options.logs); !left_out.empty())
    logs.remarks.push_back(std::move(left_out));
  input.reset();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  if (logs.analysis.evidence.rows == 0 && !logs.analysis.complete) return interrupted_early();
  if (!options.baseline.empty())
    logs.gate = gate_against(logs, options.baseline, baseline, options.how.within);
  if (!options.junit.empty()) write_file(options.junit, junit_xml(logs, options.how.confidence));
  if (!options.markdown.empty()) write_file(options.markdown, markdown_summary(logs));
  const std::int64_t rows = logs.analysis.evidence.rows;
  const int code = study_exit_code(logs.analysis.complete, lost_any(logs), fails(logs), options);
  const Document document = log_document(std::move(logs));
  print(document, options);
  if (!options.quiet) {
    say(fmt::format("{} in {:.2f} s, {:.0f} rows/s", counted(rows, "row"), elapsed.count(),
                    static_cast<double>(rows) / elapsed.count()));
  }
  write_report(document, options);
  return code;
}

}  // namespace

void add_check_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("check", "verdicts on logs of any filter");
  auto options = std::make_shared<CheckArguments>();
  command
      ->add_option("logs", options->logs, "log files, or folders of them (docs/logs.md); -: standard input")
      ->required();
  std::vector<std::string> inputs = {"auto"};
  for (const LogFormat& format : log_formats()) inputs.emplace_back(format.name);
  command->add_option("--input", options->how.format, "format of the logs; auto: seen from how each begins")
      ->check(CLI::IsMember(inputs))
      ->capture_default_str();
  command->add_flag("--pool", options->pool, "several logs are runs of one filter: judge them together");
  CLI::Option* const listing =
      command->add_flag("--list", options->list, "say what is in the logs, and judge nothing");
  command
      ->add_option("--topic", options->how.reading.topic,
                   "bags: the estimate, where several topics could be it")
      ->type_name("TOPIC");
  command
      ->add_option("--truth-topic", options->how.reading.truth_topic,
                   "bags, simulated flights: the truth, in the same file")
      ->type_name("TOPIC");
  command->add_option("--instance", options->how.reading.instance,
                      "of several estimators in one flight log, the one to judge");
  command->add_flag("--partial", options->how.reading.partial,
                    "judge what comes before the place where a file is cut off or corrupted");
  command
      ->add_option("--truth", options->how.truths,
                   "trajectories, bags: the truth, one file for all logs or one for each (repeatable)")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command
      ->add_option("--max-time-difference", options->how.reading.matching.max_time_difference_s,
                   "how far the truth used may be from an estimate, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--truth-time", options->truth_time, "which truth belongs to an estimate")
      ->check(CLI::IsMember({"interpolated", "nearest"}))
      ->capture_default_str();
  command->add_option("--align", options->align, "move the truth onto the estimate first")
      ->check(CLI::IsMember({"none", "se2", "yaw", "se3"}))
      ->capture_default_str();
  command->add_option(
      "--time-offset", options->time_offset,
      "poses: by how much the truth's times are ahead of the estimate's, s; estimate: one of all "
      "logs, found from the errors, reported with its interval, and used; each: one of each log");
  command
      ->add_option("--lever-arm", options->lever_arm,
                   "poses: where the truth's frame sits on the estimate's body: x,y,z (m), or with its "
                   "rotation qx,qy,qz,qw")
      ->type_name("LIST");
  command
      ->add_option(
          "--orientation-error", options->orientation_error,
          "what the orientation's part of a covariance speaks of; without it body for tum, world for "
          "poses and bags; planar: x, y and yaw alone")
      ->check(CLI::IsMember({"body", "world", "rpy", "planar"}));
  std::vector<std::string> charts;
  for (const PoseChart& chart : pose_charts()) charts.emplace_back(chart.name);
  command
      ->add_option("--chart", options->chart,
                   "how a library writes the covariance of a pose: order, axes and unit of its rows "
                   "(docs/logs.md); tum, poses, bags")
      ->check(CLI::IsMember(charts))
      ->excludes("--orientation-error");
  command->add_option("--confidence", options->how.confidence, "of each verdict")
      ->check(CLI::Range(kLeastConfidence, kMostConfidence))
      ->capture_default_str();
  command
      ->add_option(
          "--within", options->how.within,
          "margin, of a factor between 1/(1 + this) and 1 + this: within it mean NEES and NIS are told as "
          "proved right, and with --baseline a factor on P may move; the verdict does not depend on it")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command->add_flag("--sensitivity", options->how.sensitivity,
                    "also the verdicts without gross outliers (beyond the upper 1e-6 quantile)");
  add_threads_option(*command, options->threads);
  add_fail_option(*command, *options);
  command->add_option(
      "--baseline", options->baseline,
      "document of an earlier check --format json: --fail-on-inconsistent then fails where something "
      "is worse than there");
  command->add_option("--junit", options->junit, "write the tests as JUnit XML into this file");
  command->add_option("--markdown", options->markdown, "write a summary in Markdown into this file");
  for (const char* name : {"--junit", "--markdown"}) command->get_option(name)->check(writable_file);
  for (const char* name : {"--baseline", "--junit", "--markdown"})
    command->get_option(name)->type_name("FILE");
  add_output_options(*command, *options);
  for (const char* judging :
       {"--out", "--baseline", "--junit", "--markdown", "--sensitivity", "--fail-on-inconsistent"})
    listing->excludes(command->get_option(judging));
  static constexpr const char* kExamples[] = {
      "credence run figure1_two_landmarks --log out/logs --fresh && credence check out/logs",
      "credence check out/logs --out out/check",
      "credence check --pool out/logs/*.csv --sensitivity --format json",
      "credence check out/logs --format json > main.json    # of the version to compare with; then",
      "credence check out/logs --baseline main.json --junit check.xml --fail-on-inconsistent",
      "MY_FILTER | credence check -",
      "credence check FLIGHT.ulg --list",
      "credence check FLIGHT.ulg --instance 1",
      "credence check RUN.mcap --topic /odom --truth-topic /gt",
      "credence check RUN.bag --truth TRUTH --align yaw --orientation-error planar",
      "credence check ESTIMATE.tum --truth TRUTH --chart gtsam",
      "credence check POSES.csv --truth TRUTH    # with 6x6 covariances, as of ros2 topic echo --csv",
      "credence check ESTIMATE.tum --truth TRUTH --time-offset estimate --lever-arm 0.1,0,0.3",
      "credence check ESTIMATE --input openvins --truth TRUTH --align yaw"};
  command->footer(examples(kExamples));
  command->callback([options] {
    std::optional<StandardInputFile> input;
    for (std::string& log : options->logs) {
      if (log != "-" || input) continue;
      input.emplace();
      log = StandardInputFile::kName;
    }
    if (input && catch_interrupt().load()) throw ExitStatus{interrupted_early()};
    throw ExitStatus{options->list ? list(*options, input) : check(*options, input)};
  });
}

}  // namespace credence::internal
