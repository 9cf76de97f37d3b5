#pragma once

#include <vector>

#include "montecarlo/scenario/scenario_schema.h"

namespace credence {

/// The rows of the planar world: those of every SLAM world, path, vehicle and sensor, noise and start.
std::vector<KeyRow> planar_keys();

/// Rows that other worlds have too, with another condition perhaps.
KeyRow speed_key();
KeyRow time_step_key();
KeyRow range_std_key();
KeyRow bearing_std_key();
KeyRow initial_position_key();

}  // namespace credence
