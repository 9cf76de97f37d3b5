#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// The problem of a scenario of this world, whatever its estimator.
LinearProblem linear_world_problem(const Scenario& scenario);

/// The layout of n states and m measurements of a linear world: a block for each name before a dot, or for
/// each state. `R` is what the filter assumes; `constant`: every measurement is there at every step.
RunLayout linear_layout(std::vector<std::string> states, const Matrix& R, bool constant);

}  // namespace credence::internal
