#pragma once

#include <string>
#include <vector>

#include "core/models/linear_model.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

/// @file
/// The matrices of a linear world as a scenario writes them, in [world] for the truth and in [filter] for
/// what the filter believes.

namespace credence::internal {

/// The rows of the linear world.
std::vector<KeyRow> linear_keys();

/// Refuses matrices that do not go together, are not symmetric or not positive semidefinite, and names of
/// states that are not as many.
void check_linear(const Scenario& scenario, const Refusal& refuse);

/// The matrices of [world], or of [filter] where they are given there, before any scale, of each step of the
/// period. Good for a scenario that check_linear does not refuse.
std::vector<LinearModel> linear_truth(const Scenario& scenario);
std::vector<LinearModel> linear_belief(const Scenario& scenario);

/// K of filter.gain, n×m, and the states of filter.considered; empty where they are not given.
Matrix linear_gain(const Scenario& scenario);
std::vector<Index> considered_states(const Scenario& scenario);

/// The names of the states: x1, x2, … unless world.states gives others.
std::vector<std::string> linear_state_names(const Scenario& scenario);

}  // namespace credence::internal
