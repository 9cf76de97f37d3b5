#include "montecarlo/worlds/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/memory_need.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

constexpr std::array kWorlds = {
    &kMonobotWorld,      &kPlanarWorld,   &kLinearWorld,   &kTrackingWorld,    &kPlanarSlamWorld,
    &kLocalisationWorld, &kInertialWorld, &kPendulumWorld, &kSpatialSlamWorld,
};

/// The experiment, the statistics of its steps, and a bit for each chunk.
void require_experiment_memory(const Scenario& scenario) {
  const World& world = world_of(scenario);
  const std::string size = world.size_text != nullptr
                               ? world.size_text(scenario)
                               : fmt::format("world.model = \"{}\"", world.schema.name);
  require_memory(least_experiment_bytes(scenario),
                 fmt::format("{}, study.steps = {}", size, scenario.study.steps));
}

}  // namespace

std::span<const World* const> worlds() { return kWorlds; }

std::span<const WorldSchema* const> world_schemas() {
  static const auto schemas = [] {
    std::array<const WorldSchema*, kWorlds.size()> result{};
    std::ranges::transform(kWorlds, result.begin(), [](const World* world) { return &world->schema; });
    return result;
  }();
  return schemas;
}

const World& world_of(const Scenario& scenario) {
  const auto found = std::ranges::find_if(
      kWorlds, [&](const World* world) { return world->schema.name == scenario.world.model; });
  if (found == kWorlds.end()) {
    throw std::invalid_argument(fmt::format("no world is called \"{}\"", scenario.world.model));
  }
  return **found;
}

std::optional<LinearProblem> linear_problem(const Scenario& scenario) {
  const World& world = world_of(scenario);
  return world.linear_problem == nullptr ? std::nullopt : world.linear_problem(scenario);
}

std::unique_ptr<Experiment> make_experiment(const Scenario& scenario) {
  require_experiment_memory(scenario);
  std::optional<LinearProblem> problem = linear_problem(scenario);
  std::unique_ptr<Experiment> experiment =
      problem ? make_linear_experiment(std::move(*problem), scenario.study.steps, noise_source(scenario))
              : world_of(scenario).experiment(scenario);
  experiment->assume_inflated(scenario.filter.inflation != FilterInflation::none);
  return experiment;
}

double step_s(const Scenario& scenario) {
  return find_scenario_key("world", "dt")->of_world(scenario.world.model) ? scenario.world.dt : 0.0;
}

std::string world_text(const Scenario& scenario) { return world_of(scenario).text(scenario); }

double least_experiment_bytes(const Scenario& scenario) {
  const double chunks = static_cast<double>(scenario.most_runs()) / static_cast<double>(kChunkRuns);
  const World& world = world_of(scenario);
  const double doubles = world.least_doubles == nullptr ? 0.0 : world.least_doubles(scenario);
  return chunks / 8.0 + sizeof(double) * doubles +
         sizeof(StepStatistics) * static_cast<double>(scenario.study.steps);
}

std::optional<PosteriorBound> posterior_bound(const Scenario& scenario) {
  const World& world = world_of(scenario);
  if (world.posterior_bound == nullptr) return std::nullopt;
  if (std::string reason = no_bound_reason(scenario); !reason.empty()) {
    return PosteriorBound{.reason = std::move(reason)};
  }
  return world.posterior_bound(scenario);
}

}  // namespace credence::internal
