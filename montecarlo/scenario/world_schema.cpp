#include "montecarlo/scenario/world_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace credence::internal {
namespace {

const WorldSchema& world_named(std::string_view name) {
  const WorldSchema* const world = find_world(name);
  if (world == nullptr) throw std::invalid_argument(fmt::format("no world is called \"{}\"", name));
  return *world;
}

}  // namespace

const WorldSchema* find_world(std::string_view name) {
  const auto worlds = world_schemas();
  const auto found =
      std::ranges::find_if(worlds, [&](const WorldSchema* world) { return world->name == name; });
  return found == worlds.end() ? nullptr : *found;
}

BlockLayout block_layout(const Scenario& scenario) {
  return world_named(scenario.world.model).blocks(scenario);
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

Scenario default_scenario(std::string_view model) {
  const WorldSchema& world = world_named(model);
  Scenario scenario;
  scenario.world.model = model;
  if (world.set_defaults != nullptr) world.set_defaults(scenario);
  return scenario;
}

}  // namespace credence
