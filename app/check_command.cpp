#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "analysis/evidence/study_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/study_runner.h"
#include "app/tell_report.h"
#include "app/terminal_text.h"
#include "datasets/logs/judge_logs.h"
#include "datasets/logs/trajectory_judge.h"
#include "reports/document/log_report.h"

namespace credence {
namespace {

namespace fs = std::filesystem;

struct CheckOptions : CommonOptions {
  std::vector<std::string> logs;
  double confidence = 0.95;
  bool sensitivity = false;
  std::string input = "credence";
  std::vector<std::string> truths;
  std::string orientation_error = "body", truth_time = "interpolated", align = "none";
  double max_time_difference_s = 0.02;
};

TruthAlignment alignment_named(const std::string& name) {
  return name == "se2"   ? TruthAlignment::se2
         : name == "se3" ? TruthAlignment::se3
         : name == "yaw" ? TruthAlignment::yaw
                         : TruthAlignment::none;
}

/// What reads the logs, for the formats that need a truth; none for our own, which holds it.
std::unique_ptr<TrajectoryJudge> trajectory_judge(const CheckOptions& o, const std::vector<fs::path>& files) {
  if (o.input == "credence") {
    if (!o.truths.empty())
      throw std::invalid_argument("--truth: name the format of the logs too, by --input");
    return nullptr;
  }
  if (o.truths.empty())
    throw std::invalid_argument(fmt::format("--input {}: name the truth by --truth", o.input));
  const TrajectoryFormat format = o.input == "openvins" ? TrajectoryFormat::openvins
                                  : o.input == "cnspy"  ? TrajectoryFormat::cnspy
                                                        : TrajectoryFormat::tum;
  const TruthTime time = o.truth_time == "nearest" ? TruthTime::nearest : TruthTime::interpolated;
  return std::make_unique<TrajectoryJudge>(
      files, o.truths, format, PoseErrorAxes{.orientation_in_world = o.orientation_error == "world"},
      TrajectoryMatching{.max_time_difference_s = o.max_time_difference_s,
                         .truth_time = time,
                         .alignment = alignment_named(o.align)});
}

std::string format_text(const CheckOptions& o) {
  if (o.input == "credence") return "Credence CSV";
  return fmt::format("{}; truth {}, at most {:g} s away; alignment of the truth: {}", o.input, o.truth_time,
                     o.max_time_difference_s, o.align);
}

LogJudgeResult judge(const CheckOptions& options, const std::vector<fs::path>& files,
                     const LogFileReader& read) {
  constexpr std::int64_t kMegabyte = 1'000'000;
  StudyProgress progress;
  for (const fs::path& file : files) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    if (!error) progress.runs_total += static_cast<std::int64_t>(size);
  }
  progress.runs_total = progress.runs_total / kMegabyte + 1;
  ProgressDisplay display("check", options.quiet, "MB");
  LogJudgeOptions judging;
  judging.threads = options.threads;
  judging.stop = &catch_interrupt();
  judging.progress = [&](std::int64_t bytes) {
    progress.runs_done = bytes / kMegabyte;
    display.show(progress);
  };
  return judge_logs(files, read, judging);
}

int check(const CheckOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<fs::path> files = log_files(options.logs);
  const std::unique_ptr<TrajectoryJudge> trajectories = trajectory_judge(options, files);
  LogJudgeResult result = judge(options, files, trajectories ? trajectories->reader() : read_own_log);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  if (result.evidence.rows == 0 && !result.complete) {
    say("credence: interrupted before the first rows were judged");
    return kInterrupted;
  }
  CheckedLogs logs{
      .name = fs::path(options.logs.front()).stem().string(),
      .format = format_text(options),
      .files = result.files,
      .unmatched_rows = trajectories ? trajectories->unmatched() : 0,
      .analysis = analyse_logs(std::move(result.evidence),
                               {.confidence = options.confidence, .sensitivity = options.sensitivity})};
  logs.analysis.complete = result.complete;
  if (options.format == "json") {
    fmt::print("{}\n", log_json(logs));
  } else {
    fmt::print("{}", terminal_text(log_table(logs)));
  }
  const std::int64_t rows = logs.analysis.evidence.rows;
  if (!options.quiet) {
    say(fmt::format("{} rows in {:.2f} s, {:.0f} rows/s", rows, elapsed.count(),
                    static_cast<double>(rows) / elapsed.count()));
  }
  if (!options.out.empty()) {
    write_log_report(options.out, logs);
    tell_report(options);
  }
  const Evidence& s = logs.analysis.evidence;
  return study_exit_code(logs.analysis.complete, s.rejected_rows() > 0 || !s.study.failures.empty(),
                         is_inconsistent(logs.analysis.judgement.word.verdict), options);
}

}  // namespace

void add_check_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("check", "verdicts on logs of any filter");
  auto options = std::make_shared<CheckOptions>();
  command->add_option("logs", options->logs, "log files, or folders of *.csv (docs/formats.md)")->required();
  command->add_option("--input", options->input, "format of the logs")
      ->check(CLI::IsMember({"credence", "tum", "openvins", "cnspy"}))
      ->capture_default_str();
  command
      ->add_option("--truth", options->truths,
                   "trajectories: the truth, one file for all logs or one for each (repeatable)")
      ->allow_extra_args(false);
  command
      ->add_option("--max-time-difference", options->max_time_difference_s,
                   "trajectories: how far the truth used may be from an estimate, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--truth-time", options->truth_time, "trajectories: which truth belongs to an estimate")
      ->check(CLI::IsMember({"interpolated", "nearest"}))
      ->capture_default_str();
  command->add_option("--align", options->align, "trajectories: move the truth onto the estimate first")
      ->check(CLI::IsMember({"none", "se2", "yaw", "se3"}))
      ->capture_default_str();
  command
      ->add_option("--orientation-error", options->orientation_error,
                   "tum: axes of the orientation's covariance")
      ->check(CLI::IsMember({"body", "world"}))
      ->capture_default_str();
  command->add_option("--confidence", options->confidence, "of each verdict")
      ->check(CLI::Range(0.5, 0.999999))
      ->capture_default_str();
  command->add_flag("--sensitivity", options->sensitivity,
                    "also the verdicts without gross outliers (beyond the upper 1e-6 quantile)");
  add_threads_option(*command, options->threads);
  add_fail_option(*command, *options);
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence run scenarios/figure1_two_landmarks.toml --log out/logs && credence check out/logs",
      "credence check out/logs --out out/check", "credence check out/logs/*.csv --sensitivity --format json",
      "credence check ESTIMATE --input openvins --truth TRUTH --align yaw"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{check(*options)}; });
}

}  // namespace credence
