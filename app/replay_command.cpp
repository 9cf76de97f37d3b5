#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/common_options.h"
#include "datasets/carpark_replay.h"
#include "datasets/mrclam_replay.h"
#include "reports/replay_report.h"
#include "reports/text_table.h"

namespace credence {
namespace {

namespace fs = std::filesystem;

struct ReplayOptions : CommonOptions {
  std::string dataset;
  std::string data;
  int robot = 1;
};

/// DIR itself or, where it has one, its subfolder of the data set.
fs::path data_folder(const ReplayOptions& options, const char* subfolder) {
  if (options.data.empty()) {
    throw std::invalid_argument(
        "--data: name the folder with the data set, or set CREDENCE_DATA (docs/datasets.md)");
  }
  const fs::path nested = fs::path(options.data) / subfolder;
  return fs::is_directory(nested) ? nested : fs::path(options.data);
}

ReplaySettings with_overrides(ReplaySettings settings, const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument(fmt::format("--set {}: accepted is section.key=value", text));
    }
    set_replay_setting(settings, text.substr(0, equals), text.substr(equals + 1));
  }
  check_replay_settings(settings);
  return settings;
}

ReplayResult replay_dataset(const ReplayOptions& options) {
  if (options.dataset == "carpark") {
    const ReplaySettings settings = with_overrides(carpark_settings(), options.settings);
    return replay_carpark(read_carpark(data_folder(options, "carpark")), settings);
  }
  const ReplaySettings settings = with_overrides(mrclam_settings(options.robot), options.settings);
  return replay_mrclam(read_mrclam(data_folder(options, "mrclam7"), options.robot), settings);
}

int replay(const ReplayOptions& options) {
  const ReplayResult result = replay_dataset(options);
  if (options.format == "json") {
    fmt::print("{}\n", replay_json(result));
  } else {
    fmt::print("{}", text_table(replay_table(result), isatty(STDOUT_FILENO) == 1));
  }
  if (!options.out.empty()) {
    for (const std::string& problem : write_replay_report(options.out, result)) {
      fmt::print(stderr, "credence: figure not drawn: {}\n", problem);
    }
    if (!options.quiet) fmt::print(stderr, "Report: {}\n", (fs::path(options.out) / "index.html").string());
  }
  return result.failed > 0 ? kSomeFailed : kDone;
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("replay", "EKF-SLAM on real data: path, map and innovations against what is known");
  auto options = std::make_shared<ReplayOptions>();
  command->add_option("dataset", options->dataset, "which data set")
      ->required()
      ->check(CLI::IsMember({"carpark", "mrclam"}));
  command->add_option("--data", options->data, "folder of the data; default: CREDENCE_DATA")
      ->envname("CREDENCE_DATA");
  command->add_option("--robot", options->robot, "mrclam: which robot's log")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  command->add_option("--set", options->settings, "override a setting: section.key=value (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence replay carpark --data DIR",
      "credence replay carpark --data DIR --set filter.inflation=map --out out/map",
      "credence replay mrclam --data DIR --robot 3"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{replay(*options)}; });
}

}  // namespace credence
