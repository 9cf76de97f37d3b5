#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// Any linear time-invariant system, its matrices written in the scenario, and a filter that may believe in
/// others (LinearModel, core/models/linear_model.h).
extern const World kLinearWorld;

/// The problem of a scenario of this world, whatever its estimator.
LinearProblem linear_world_problem(const Scenario& scenario);

/// The layout of n states and m measurements of a linear world: a block for each name before a dot, or for
/// each state. `R` is what the filter assumes; `constant`: every measurement is there at every step.
RunLayout linear_layout(std::vector<std::string> states, const Matrix& R, bool constant);

}  // namespace credence::internal
