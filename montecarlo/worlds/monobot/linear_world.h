#pragma once

#include "core/models/linear_model.h"
#include "montecarlo/engine/experiment.h"

namespace credence {

/// Where the truth of a linear run starts: the vehicle at −1 m, the landmarks around +1 m (theory, section
/// 2).
Vector linear_start(const BlockLayout& layout);

/// What a trace says of a linear world.
RunTrace describe_linear_world(const LinearModel& model);

/// The numbers of the landmarks in the order of the state.
std::vector<int> linear_landmarks(const BlockLayout& layout);

}  // namespace credence
