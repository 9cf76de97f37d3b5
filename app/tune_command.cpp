#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "analysis/tuning/tune_scenario.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/say.h"
#include "app/scenario_files.h"
#include "app/tell_report.h"
#include "app/terminal_text.h"
#include "app/this_command.h"
#include "datasets/logs/innovation_record.h"
#include "datasets/logs/log_format.h"
#include "reports/document/log_tune_report.h"
#include "reports/document/tune_report.h"
#include "reports/render/atomic_file.h"
#include "reports/render/utf8_text.h"

namespace credence {
namespace {

namespace fs = std::filesystem;

constexpr double kLogConfidence = 0.95;

struct TuneOptions : CommonOptions {
  std::vector<std::string> inputs;
  std::string free = "Q,R";
  std::string write;
};

/// A file that is there is somebody's.
void require_new(const std::string& file) {
  if (file.empty() || !fs::exists(fs::symlink_status(file))) return;
  throw std::invalid_argument(fmt::format("--write {}: the file exists; nothing is written over", file));
}

void print_tuning(const ScenarioTuning& tuning) {
  fmt::print("{}.\n\n{}\n{}\n{}", printable_line(tune_answer(tuning).text),
             terminal_text(tune_forecast_table(tuning.tuning.forecast)), terminal_text(tune_table(tuning)),
             terminal_text(tune_gain_table(tuning)));
  for (const std::string& sentence : tune_sentences(tuning)) fmt::print("{}\n", printable_line(sentence));
}

int tune_scenario_file(const TuneOptions& options) {
  TuneRequest request;
  request.free = parse_free_noise(options.free);
  request.threads = options.threads;
  request.stop = &catch_interrupt();
  const auto tuning = naming_file(options.inputs.front(), [&] {
    return tune_scenario(open_one_scenario(options.inputs.front(), options.overrides()), request);
  });
  if (!tuning) {
    say("credence: interrupted; nothing is kept of a tuning that is not done");
    return kInterrupted;
  }
  if (options.format == "json") {
    fmt::print("{}\n", tune_json(*tuning));
  } else {
    print_tuning(*tuning);
  }
  if (!options.out.empty()) {
    write_tune_report(options.out, *tuning, make_provenance(this_command()));
    tell_report(options);
  }
  if (!options.write.empty()) {
    if (!tuning->tuning.anything_known()) {
      throw std::invalid_argument(
          fmt::format("--write {}: nothing could be told, so there is no tuned scenario", options.write));
    }
    write_file(options.write, tuned_toml(*tuning));
  }
  const bool inconsistent = tuning->held_out && is_inconsistent(overall_verdict(tuning->held_out->after));
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

int tune_logs(const TuneOptions& options) {
  if (!options.write.empty() || !options.out.empty() || !options.overrides().empty()) {
    throw std::invalid_argument(
        "a log is no scenario: --write, --out, --set, --runs, --steps and --seed have no meaning for it");
  }
  const std::vector<fs::path> files = log_files(options.inputs);
  const LogReadOptions reading{.truth = TruthFiles(files, {})};
  const std::vector<SensorRecord> records = read_innovations(
      files, [&](const fs::path& file, LogSink& sink) { log_format_of(file).read(file, reading, sink); });
  if (records.empty()) throw std::invalid_argument("the logs hold no innovations with their covariance");
  std::vector<InnovationTuning> sensors;
  sensors.reserve(records.size());
  for (const SensorRecord& record : records) sensors.push_back(tune_innovations(record, kLogConfidence));
  const std::string name = fs::path(options.inputs.front()).stem().string();
  if (options.format == "json") {
    fmt::print("{}\n", log_tune_json(name, sensors));
  } else {
    fmt::print("{}", terminal_text(log_tune_table(name, sensors)));
    for (const std::string& sentence : log_tune_sentences(sensors)) fmt::print("{}\n", sentence);
  }
  const bool inconsistent = std::ranges::any_of(
      sensors, [](const InnovationTuning& t) { return is_inconsistent(t.left_out_parts.verdict); });
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

/// A scenario is a file of TOML, or one that comes with the program; everything else is a log.
bool is_scenario(const std::string& input) {
  std::error_code error;
  return input.ends_with(".toml") || (!fs::exists(input, error) && is_own_scenario(input));
}

int tune_input(const TuneOptions& options) {
  require_new(options.write);
  if (!is_scenario(options.inputs.front())) return tune_logs(options);
  if (options.inputs.size() > 1) throw ScenarioError("tune: accepts exactly one scenario, or logs");
  return tune_scenario_file(options);
}

}  // namespace

void add_tune_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "tune", "which noise would make it consistent: value, interval, verdict on fresh runs");
  auto options = std::make_shared<TuneOptions>();
  command
      ->add_option("input", options->inputs,
                   "a scenario file, or logs with innovations and their covariance (docs/logs.md)")
      ->required();
  command
      ->add_option(
          "--free", options->free,
          "what is tuned: Q, R, P0 for one factor each, diag(Q) for every variance, full(Q) for every "
          "element; separated by commas")
      ->capture_default_str();
  command->add_option("--write", options->write, "a new file for the tuned scenario")->type_name("FILE");
  add_common_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence tune scenarios/tracking.toml",
      "credence tune scenarios/linear.toml --free 'diag(Q),R' --write tuned.toml",
      "credence tune scenarios/linear.toml --free 'diag(Q),R' --out out/tune --format json",
      "credence tune out/logs"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{tune_input(*options)}; });
}

}  // namespace credence
