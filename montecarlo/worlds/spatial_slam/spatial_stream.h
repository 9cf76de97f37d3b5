#pragma once

#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {

/// A vehicle in space whose odometry is read with noise, v (m) and ω (rad) of a step, and the places (m) of
/// the landmarks in view in its frame. Of the noise the scenario tells the shares, by what is read. Throws as
/// make_spatial_world does.
WorldStream spatial_stream(const Scenario& scenario);

}  // namespace credence::internal
