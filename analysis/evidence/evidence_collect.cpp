#include <algorithm>
#include <mutex>

#include "analysis/evidence/battery.h"
#include "core/parallel_tasks.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/filter_setup.h"
#include "montecarlo/worlds/planar/planar_drive.h"

namespace credence {
namespace {

/// Of one landmark's measurement, as the filter believes it to be.
Vector assumed_measurement_variances(const Scenario& scenario) {
  if (scenario.world.model == WorldModel::monobot) return make_assumed_model(scenario).R.diagonal().head(1);
  return scenario.filter.measurement_scale * PlanarNoise::of(scenario).measurement_std.cwiseAbs2();
}

BatteryShape shape_of(const Scenario& scenario) {
  const BlockLayout layout = block_layout(scenario);
  const bool all_seen =
      scenario.world.model == WorldModel::monobot && scenario.noise.detection_probability == 1.0;
  return {.steps = static_cast<std::size_t>(scenario.study.steps),
          .vehicle_dim = layout.vehicle,
          .landmark_dim = layout.landmark,
          .landmarks = layout.landmarks,
          .innovation_dim = all_seen ? make_true_model(scenario).measurement_dim() : 0,
          .measurement_variances = assumed_measurement_variances(scenario)};
}

BatteryStatistics play(const BatteryShape& shape, const Experiment& experiment, std::int64_t first,
                       std::int64_t last) {
  BatteryStatistics statistics(shape);
  for (std::int64_t run = first; run < last; ++run) {
    statistics.begin_run();
    statistics.end_run(experiment.visit(run, [&](const TraceStep& step) { statistics.add(step); }));
  }
  return statistics;
}

}  // namespace

std::int64_t battery_runs(const Scenario& scenario, std::int64_t runs) {
  constexpr std::int64_t kMost = 1024;
  constexpr double kOperations = 2e10;
  const auto n = static_cast<double>(block_layout(scenario).state_dim());
  const double of_a_run = static_cast<double>(scenario.study.steps) * (n * n * n + 1e4);
  const auto affordable = static_cast<std::int64_t>(std::min(1e9, kOperations / of_a_run));
  return std::min(runs, std::clamp(affordable / kChunkRuns * kChunkRuns, kChunkRuns, kMost));
}

std::optional<BatteryStatistics> collect_battery(const Scenario& scenario, const Experiment& experiment,
                                                 std::int64_t runs, const EngineOptions& options) {
  const BatteryShape shape = shape_of(scenario);
  const std::int64_t chunks = (runs + kChunkRuns - 1) / kChunkRuns;
  std::vector<BatteryStatistics> parts(static_cast<std::size_t>(chunks), BatteryStatistics(shape));
  StudyProgress progress{.runs_total = runs};
  std::mutex mutex;
  for_each_task(chunks, options.threads, options.stop, [&](std::int64_t chunk) {
    const std::int64_t first = chunk * kChunkRuns, last = std::min(runs, first + kChunkRuns);
    parts[static_cast<std::size_t>(chunk)] = play(shape, experiment, first, last);
    const std::lock_guard lock(mutex);
    progress.runs_done += last - first;
    if (options.progress) options.progress(progress);
  });
  if (progress.runs_done < runs) return std::nullopt;
  BatteryStatistics all(shape);
  for (const BatteryStatistics& part : parts) all.merge(part);
  return all;
}

}  // namespace credence
