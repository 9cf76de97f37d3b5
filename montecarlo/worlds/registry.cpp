#include "montecarlo/worlds/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/memory_need.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/inertial/inertial_world.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/linear/linear_world.h"
#include "montecarlo/worlds/localisation/localisation_world.h"
#include "montecarlo/worlds/monobot/monobot_world.h"
#include "montecarlo/worlds/pendulum/pendulum_world.h"
#include "montecarlo/worlds/planar/planar_registration.h"
#include "montecarlo/worlds/planar_slam/planar_slam_world.h"
#include "montecarlo/worlds/spatial_slam/spatial_slam_world.h"
#include "montecarlo/worlds/tracking/tracking_world.h"

namespace credence::internal {
namespace {

constexpr std::array kWorlds = {
    &kMonobotWorld,      &kPlanarWorld,   &kLinearWorld,   &kTrackingWorld,    &kPlanarSlamWorld,
    &kLocalisationWorld, &kInertialWorld, &kPendulumWorld, &kSpatialSlamWorld,
};

/// The experiment, the statistics of its steps, and a bit for each chunk.
void require_experiment_memory(const Scenario& scenario) {
  require_memory(
      least_experiment_bytes(scenario),
      fmt::format("{}, study.steps = {}", world_of(scenario).size_text(scenario), scenario.study.steps));
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

std::string world_text(const Scenario& scenario) { return world_of(scenario).text(scenario); }

double least_experiment_bytes(const Scenario& scenario) {
  const double chunks = static_cast<double>(scenario.most_runs()) / static_cast<double>(kChunkRuns);
  return chunks / 8.0 + sizeof(double) * world_of(scenario).least_doubles(scenario) +
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
