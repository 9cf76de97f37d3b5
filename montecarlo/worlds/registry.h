#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// All worlds. A new one is a folder of its own and one line each in world_list.h and registry.cpp.
std::span<const World* const> worlds();

/// The world of a scenario. Throws std::invalid_argument for a model that there is not.
const World& world_of(const Scenario& scenario);

/// The experiment of a scenario. Throws std::invalid_argument where it needs more memory than the machine has
/// or its world cannot be made.
std::unique_ptr<Experiment> make_experiment(const Scenario& scenario);

/// The linear problem that a scenario is, or nothing.
std::optional<LinearProblem> linear_problem(const Scenario& scenario);

/// The time of a step, s; 0 in a world whose steps have none.
double step_s(const Scenario& scenario);

/// "monobot, 2 landmarks, partially observable": the world of a scenario in a few words.
std::string world_text(const Scenario& scenario);

/// Bytes that the experiment of a scenario, the statistics of its runs and a bit for each chunk need at the
/// least: what is more than a machine has can be refused before it is begun.
double least_experiment_bytes(const Scenario& scenario);

/// What no filter's error is below in the world of this scenario, or the reason why there is none; nothing
/// where the world knows of no bound.
std::optional<PosteriorBound> posterior_bound(const Scenario& scenario);

}  // namespace credence::internal
