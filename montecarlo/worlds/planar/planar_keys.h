#pragma once

#include <string_view>
#include <vector>

#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {

/// The rows of the planar world: those of every SLAM world, path, vehicle and sensor, noise and start.
std::vector<KeyRow> planar_keys();

/// One of them, for a world that has it too, on a condition of its own.
KeyRow planar_row(std::string_view section, std::string_view name,
                  bool (*accepted)(const Scenario&) = nullptr, std::string_view accepted_when = {});

}  // namespace credence::internal
