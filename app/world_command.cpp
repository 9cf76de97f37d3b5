#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "app/binary_frames.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/scenario_files.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar/planar_drive.h"
#include "montecarlo/worlds/planar/planar_world.h"
#include "montecarlo/worlds/registry.h"

namespace credence {
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
  Stream(const Scenario& scenario, bool frames, const std::string& columns, const std::string& comments = "")
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

void append(std::vector<double>& row, const Vector& values) {
  row.insert(row.end(), values.begin(), values.end());
}

Vector blank(Index size) { return Vector::Constant(size, std::nan("")); }

std::string names(const std::string& kind, const std::vector<std::string>& of) {
  std::string text;
  for (const std::string& name : of) text += fmt::format(",{}.{}", kind, name);
  return text;
}

/// Numbers of the measurement of a step; 0 where it is no vector.
Index measured_numbers(const Experiment& experiment) {
  Index most = 0;
  experiment.visit(0, [&](const TraceStep& now) { most = std::max(most, now.z.size()); });
  return most;
}

/// A world whose measurement is one vector, and where nothing is steered.
void stream_vectors(const Scenario& scenario, const Experiment& experiment, Index m, bool frames) {
  std::string columns =
      names("prior", experiment.layout().states) + names("truth", experiment.layout().states);
  for (Index i = 0; i < m; ++i) columns += fmt::format(",measurement.{}", i + 1);
  const Stream out(scenario, frames, columns);
  for (std::int64_t run = 0; run < scenario.study.runs && !catch_interrupt().load(); ++run) {
    experiment.visit(run, [&](const TraceStep& now) {
      std::vector<double> row;
      append(row, now.step == 0 ? now.estimate : blank(now.estimate.size()));
      append(row, now.truth);
      append(row, now.step == 0 || now.z.size() == 0 ? blank(m) : now.z);
      out.write(run, now.step, std::move(row));
    });
  }
}

/// A vehicle in the plane: nominal controls, and range (m) and bearing (rad) of the landmarks in view.
void stream_planar(const Scenario& scenario, bool frames) {
  const PlanarWorld world = make_planar_world(scenario);
  const std::vector<std::string> pose = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  std::string columns = names("prior", pose) + names("truth", pose) + ",input.1,input.2";
  for (std::size_t i = 1; i <= world.landmarks.size(); ++i) {
    columns += fmt::format(",measurement.landmark{0}.range,measurement.landmark{0}.bearing", i);
  }
  std::string places;
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    places += fmt::format("landmark{} = {},{}\n", i + 1, world.landmarks[i].x(), world.landmarks[i].y());
  }
  const Stream out(scenario, frames, columns, places);
  PlanarDrive drive(world, PlanarNoise::of(scenario), noise_source(scenario));
  const auto seen = static_cast<Index>(2 * world.landmarks.size());
  for (std::int64_t run = 0; run < scenario.study.runs && !catch_interrupt().load(); ++run) {
    std::vector<double> row;
    append(row, drive.start(run));
    append(row, drive.pose());
    append(row, blank(2 + seen));
    out.write(run, 0, row);
    for (std::size_t k = 1; k <= world.controls.size(); ++k) {
      drive.move(k);
      Vector z = blank(seen);
      for (const auto& observation : drive.observe(k))
        z.segment<2>(2 * Index{observation.landmark}) = observation.z;
      row.clear();
      append(row, blank(3));
      append(row, drive.pose());
      append(row, world.controls[k - 1]);
      append(row, z);
      out.write(run, static_cast<std::int64_t>(k), row);
    }
  }
}

[[noreturn]] void refuse(const Scenario& scenario) {
  throw std::invalid_argument(
      fmt::format("{}: world tells measurements of worlds that measure a vector (linear ones, tracking, "
                  "pendulum), and of the "
                  "planar one",
                  world_text(scenario)));
}

int stream(const WorldOptions& options) {
  const Scenario scenario = open_one_scenario(options.scenario, options.overrides());
  naming_file(options.scenario, [&] {
    if (world_of(scenario).figure == RunFigure::plane_slam) {
      if (scenario.world.model != "planar") refuse(scenario);
      stream_planar(scenario, options.frames);
      return;
    }
    const std::unique_ptr<Experiment> experiment = make_experiment(scenario);
    const Index m = measured_numbers(*experiment);
    if (m == 0) refuse(scenario);
    stream_vectors(scenario, *experiment, m, options.frames);
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
  command->add_option("--runs", options->runs, "number of runs, instead of study.runs");
  command->add_option("--steps", options->steps, "steps of each run, instead of study.steps");
  command->add_flag("--frames", options->frames, "binary rows of float64 instead of CSV (docs/formats.md)");
  command->add_option("--seed", options->seed, "seed, instead of study.seed");
  static constexpr const char* kExamples[] = {
      "credence world tracking --runs 200 | my_filter | credence check -    # docs/formats.md",
      "credence world planar_loop --runs 1 > run.csv"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] { throw ExitStatus{stream(*options)}; });
}

}  // namespace credence
