#include "montecarlo/engine/experiment_memory.h"

#include <fmt/format.h>

#include "core/memory_need.h"
#include "montecarlo/engine/engine.h"

namespace credence {
namespace {

/// Dense models of truth and filter (F and P0, H, R), and what is kept of the filter's steps: P before and
/// after the update, ΔP, K and S. Where measurements are missed every run has steps of its own, of which none
/// is kept.
double linear_doubles(const Scenario& scenario) {
  const auto n = static_cast<double>(block_layout(scenario).state_dim());
  const auto m = static_cast<double>(scenario.world.landmarks + scenario.world.anchors);
  const double steps =
      scenario.noise.detection_probability < 1.0 ? 1.0 : static_cast<double>(scenario.study.steps);
  return 2.0 * (2.0 * n * n + n * m + m * m) + steps * (3.0 * n * n + n * m + m * m);
}

/// Places of landmarks, and a control a step.
double planar_doubles(const Scenario& scenario) {
  return 2.0 * static_cast<double>(scenario.world.landmarks + scenario.world.anchors + scenario.study.steps);
}

}  // namespace

double least_experiment_bytes(const Scenario& scenario) {
  const bool linear = scenario.world.model == WorldModel::monobot;
  const double chunks = static_cast<double>(scenario.most_runs()) / static_cast<double>(kChunkRuns);
  return chunks / 8.0 + sizeof(double) * (linear ? linear_doubles(scenario) : planar_doubles(scenario)) +
         sizeof(StepStatistics) * static_cast<double>(scenario.study.steps);
}

void require_experiment_memory(const Scenario& scenario) {
  require_memory(least_experiment_bytes(scenario),
                 fmt::format("world.landmarks = {}, world.anchors = {}, study.steps = {}",
                             scenario.world.landmarks, scenario.world.anchors, scenario.study.steps));
}

}  // namespace credence
