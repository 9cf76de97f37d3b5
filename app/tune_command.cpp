#include "app/tune_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "app/commands.h"
#include "app/scenario_files.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

/// A file that is there is somebody's.
void require_new(const std::string& file) {
  if (file.empty() || !fs::exists(fs::symlink_status(file))) return;
  throw std::invalid_argument(fmt::format("--write {}: the file exists; nothing is written over", file));
}

/// A scenario is a file of TOML, or one that comes with the program; everything else is a log.
bool is_scenario(const std::string& input) {
  std::error_code error;
  return input.ends_with(".toml") || (!fs::exists(input, error) && is_own_scenario(input));
}

bool is_data_set(const std::vector<std::string>& inputs) {
  std::error_code error;
  const std::string& first = inputs.front();
  return inputs.size() == 1 && (first == "carpark" || first == "mrclam") && !fs::exists(first, error);
}

int tune_input(const TuneOptions& options) {
  require_new(options.write);
  if (is_data_set(options.inputs)) return tune_data_set(options);
  if (!options.data.empty() || !options.robots.empty()) {
    throw std::invalid_argument("--data and --robot: only of carpark and mrclam");
  }
  if (!is_scenario(options.inputs.front())) return tune_logs(options);
  if (options.inputs.size() > 1) throw ScenarioError("tune: accepts exactly one scenario, or logs");
  return tune_scenario_file(options);
}

}  // namespace

void add_tune_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "tune", "which noise would make the filter consistent: value, interval, verdict on fresh runs");
  auto options = std::make_shared<TuneOptions>();
  command
      ->add_option("input", options->inputs,
                   "a scenario file, or a name of credence list; carpark or mrclam with --data; or logs with "
                   "innovations and their covariance (docs/logs.md)")
      ->required();
  command->add_option(
      "--free", options->free,
      "what is tuned: Q, R, P0 for one factor each, diag(Q) for every variance, full(Q) for every "
      "element; of a data set noise.range_std and the like; separated by commas (default Q,R; of a data set "
      "all of its noise)");
  command->add_option("--write", options->write, "a new file for the tuned scenario")
      ->type_name("FILE")
      ->check(writable_file);
  command
      ->add_option("--data", options->data,
                   "carpark, mrclam: folder of the data; mrclam: repeatable; default: CREDENCE_DATA")
      ->type_name("DIR")
      ->allow_extra_args(false);
  command->add_option("--robot", options->robots, "mrclam: which robots' logs, e.g. 1,3 (default all)")
      ->delimiter(',')
      ->check(CLI::Range(1, 5));
  add_common_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence tune tracking", "credence tune linear --free 'diag(Q),R' --write tuned.toml",
      "credence tune tracking --out out/tune --format json",
      "credence run figure1_two_landmarks --log out/logs --fresh && credence tune out/logs",
      "credence tune carpark --data DIR --out out/carpark"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{tune_input(*options)}; });
}

}  // namespace credence::internal
