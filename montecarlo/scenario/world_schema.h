#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/record/block_layout.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// What the scenario file knows of the worlds: their names and their rows of the table of keys. Each world
/// states its own (montecarlo/worlds), and no name of a world stands in this folder.

namespace credence::internal {

struct KeyRow;

/// How a world refuses a scenario whose values, each accepted, do not go together. Both throw, with place and
/// value of the key in front of the rule: "must be <= 3 with world.landmarks = 2".
struct Refusal {
  using Throw = std::function<void(std::string_view section, std::string_view name, const std::string& rule)>;
  Throw impossible;  ///< a sweep may leave such a point out (ImpossibleCombination)
  Throw wrong;       ///< the scenario is in error (ScenarioError)
};

/// One kind of world, as far as the scenario file goes.
struct WorldSchema {
  std::string_view name;     ///< its word in world.model
  std::string_view meaning;  ///< what it is, in a few words
  std::vector<KeyRow> (*keys)();
  void (*set_defaults)(Scenario&) = nullptr;  ///< where they are not those of the structs; null: all are
  void (*check)(const Scenario&, const Refusal&) = nullptr;  ///< null: all values go together
  BlockLayout (*blocks)(const Scenario&);                    ///< of the complete state
};

/// All worlds, in the order of the registry (montecarlo/worlds/registry.cpp).
std::span<const WorldSchema* const> world_schemas();

/// The world of this name, or nullptr.
const WorldSchema* find_world(std::string_view name);

/// How the complete state of a filter in this scenario is cut into blocks: the monobot has n_r = d = 1, the
/// planar vehicle n_r = 3 and d = 2. Throws as default_scenario does.
BlockLayout block_layout(const Scenario& scenario);

}  // namespace credence::internal

namespace credence {

/// The scenario of which everything but the model is left at its default. Throws std::invalid_argument for a
/// name that no world has.
Scenario default_scenario(std::string_view model);

}  // namespace credence
