#pragma once

#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {

/// A vehicle whose odometry is read with noise, and what its sensor says of the landmarks in view: their
/// relative positions (m), or range (m) and bearing (rad). Throws as make_odometry_world does.
WorldStream odometry_stream(const Scenario& scenario);

}  // namespace credence::internal
