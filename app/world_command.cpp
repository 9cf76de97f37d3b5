#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

#include "app/binary_frames.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/scenario_files.h"
#include "core/nan.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {
namespace {

struct WorldOptions : CommonOptions {
  std::string scenario;
  bool frames = false;
};

/// The stream: CSV, or binary frames of the same columns.
class Stream {
 public:
  /// The scenario goes ahead as comments, so that an estimator can know F, Q, R and whatever else the world
  /// is made of; `comments` more of them, each with its line's end.
  Stream(const Scenario& scenario, bool frames, const std::string& columns, const std::string& comments)
      : frames_(frames) {
    if (frames_) fmt::print("{}\n", kFramesHead);
    std::istringstream lines(canonical_toml(scenario) + comments);
    for (std::string line; std::getline(lines, line);) fmt::print("# {}\n", line);
    fmt::print("run,step{}\n", columns);
  }

  void write(std::int64_t run, std::int64_t step, std::vector<double> values) const {
    values.insert(values.begin(), {static_cast<double>(run), static_cast<double>(step)});
    if (frames_) {
      const std::string bytes = frame_of(values);
      std::fwrite(bytes.data(), 1, bytes.size(), stdout);
    } else {
      fmt::print("{}\n", csv_row(values, 2));
    }
  }

 private:
  bool frames_;
};

std::string columns(const std::string& kind, const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += fmt::format(",{}.{}", kind, name);
  return text;
}

/// `values`, or as many blanks as there are names.
void append(std::vector<double>& row, const Vector& values, const std::vector<std::string>& names) {
  row.insert(row.end(), values.begin(), values.end());
  if (values.size() == 0) row.resize(row.size() + names.size(), kNaN);
}

int stream(const WorldOptions& options) {
  const Scenario scenario = open_one_scenario(options.scenario, options.overrides());
  tell_of_stop_rule(scenario, "world");
  naming_file(options.scenario, [&] {
    const WorldStream world = world_stream(scenario);
    const Stream out(scenario, options.frames,
                     columns("prior", world.states) + columns("truth", world.states) +
                         columns("input", world.inputs) + columns("measurement", world.measurements),
                     world.notes);
    for (std::int64_t run = 0; run < scenario.study.runs && !catch_interrupt().load(); ++run) {
      world.visit(run, [&](std::int64_t step, const StreamRow& told) {
        std::vector<double> row;
        append(row, told.prior, world.states);
        append(row, told.truth, world.states);
        append(row, told.input, world.inputs);
        append(row, told.measurement, world.measurements);
        out.write(run, step, std::move(row));
      });
    }
  });
  return catch_interrupt().load() ? kInterrupted : kDone;
}

}  // namespace

void add_world_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "world", "truth, inputs and measurements of a scenario, for a filter in any language");
  auto options = std::make_shared<WorldOptions>();
  command->add_option("scenario", options->scenario, "scenario file, or a name of credence list scenarios")
      ->required();
  add_setting_option(*command, *options);
  add_study_options(*command, *options);
  command->add_flag("--frames", options->frames, "binary rows of float64 instead of CSV (docs/formats.md)");
  static constexpr const char* kExamples[] = {
      "credence world tracking --runs 200 | MY_FILTER | credence check -    # docs/formats.md",
      "credence world planar_loop --runs 1 > run.csv"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] { throw ExitStatus{stream(*options)}; });
}

}  // namespace credence::internal
