#pragma once

#include <cstdint>
#include <string>

#include "montecarlo/scenario/scenario.h"

/// @file
/// The written forms of a resolved scenario, and the names that are hashed from them.

namespace credence::internal {

/// All resolved values that play a part, as TOML in one fixed order, numbers in the fewest digits that read
/// back to the same double. Loading it gives an equal scenario (but for the name).
std::string canonical_toml(const Scenario& scenario);

/// The same values as one JSON object of sections, with the scenario's name first.
std::string scenario_to_json(const Scenario& scenario);

/// Name of a configuration: FNV-1a (64 bits, 16 hexadecimal digits) of its canonical text without
/// study.runs, study.confidence and study.stop. More runs extend a configuration; they do not make another.
std::string configuration_id(const Scenario& scenario);

/// The canonical text that configuration_id is the hash of.
std::string configuration_toml(const Scenario& scenario);

}  // namespace credence::internal

namespace credence {

/// Key of the random numbers of a world: FNV-1a (64 bits) of the canonical text of [world], [noise] and
/// [initial], so that filters compared in one sweep meet the same noise.
std::uint64_t noise_group(const Scenario& scenario);

}  // namespace credence
