#pragma once

#include "montecarlo/engine/experiment.h"
#include "montecarlo/worlds/linear/linear_problem.h"

namespace credence::internal {

/// x_0 of a run whose error at the start is `error` = x − x̂.
Vector linear_start(const LinearScene& scene, VectorRef error);

/// The numbers of the landmarks and of the states, which a linear filter has all from the start.
void name_states(const BlockLayout& layout, TraceStep& step);

/// Truth, estimate and error x̂ − x of a step, from x and `error` = x − x̂.
void set_error(const Vector& x, VectorRef error, TraceStep& step);

/// What a trace says of the world.
RunTrace describe_scene(const LinearScene& scene);

}  // namespace credence::internal
