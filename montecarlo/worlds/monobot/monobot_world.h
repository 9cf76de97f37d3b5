#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// The monobot of a scenario, its filter with the noise scaled by process_scale and measurement_scale.
LinearProblem monobot_problem(const Scenario& scenario);

/// How the runs of a monobot are shown: the vehicle starts at −1 m, the landmarks stand around +1 m.
/// `constant`: every measurement is there at every step.
LinearScene monobot_scene(const LinearModel& model, bool constant);

}  // namespace credence::internal
