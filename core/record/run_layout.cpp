#include "core/record/run_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace credence::internal {
namespace {

constexpr const char* kVehicle = "vehicle";

std::string block_of(const std::string& state) { return state.substr(0, state.find('.')); }

bool is_angle(const RunLayout& layout, Index state) { return layout.angles[static_cast<std::size_t>(state)]; }

Index angles_among(const RunLayout& layout, const std::vector<Index>& states) {
  return std::ranges::count_if(states, [&](Index i) { return is_angle(layout, i); });
}

/// In the plane.
bool is_pose(const RunLayout& layout, const std::vector<Index>& states) {
  return states.size() == 3 && angles_among(layout, states) == 1;
}

/// "x" of "vehicle.x".
std::string_view within_block(const RunLayout& layout, Index state) {
  const std::string& name = layout.states[static_cast<std::size_t>(state)];
  return std::string_view(name).substr(name.find('.') + 1);
}

/// Puts x before y, by their names, and an angle last; else as they stand.
void order_in_plane(const RunLayout& layout, std::vector<Index>& states) {
  const auto angles =
      std::stable_partition(states.begin(), states.end(), [&](Index i) { return !is_angle(layout, i); });
  if (angles - states.begin() == 2 && within_block(layout, states[0]) == "y" &&
      within_block(layout, states[1]) == "x") {
    std::swap(states[0], states[1]);
  }
}

Block* find(RunLayout& layout, const std::string& name) {
  const auto found = std::ranges::find(layout.blocks, name, &Block::name);
  return found == layout.blocks.end() ? nullptr : &*found;
}

/// "landmark9" before "landmark10", in whatever order they stand.
bool is_numbered_before(const std::string& a, const std::string& b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

/// Leaves the first landmarks by number, in the order in which they stand.
void leave_single_landmarks(std::vector<Block>& blocks) {
  std::vector<std::string> names;
  for (const Block& block : blocks) {
    if (block.part == Part::landmark) names.push_back(block.name);
  }
  if (std::ssize(names) <= kSingleLandmarks) return;
  const auto last = names.begin() + kSingleLandmarks - 1;
  std::ranges::nth_element(names, last, is_numbered_before);
  std::erase_if(blocks, [&](const Block& block) {
    return block.part == Part::landmark && is_numbered_before(*last, block.name);
  });
}

/// Metres of positions and radians of angles, where no unit is told of any state.
void add_units(RunLayout& layout) {
  if (!layout.units.empty()) return;
  for (const Block& block : layout.blocks) {
    if (block.part == Part::other) continue;
    layout.units.resize(layout.states.size());
    for (const Index state : block.states) {
      const auto i = static_cast<std::size_t>(state);
      layout.units[i] = i < layout.angles.size() && layout.angles[i] ? "rad" : "m";
    }
  }
}

/// Names the parts of a vehicle and a map, where the blocks are such.
void name_parts(RunLayout& layout) {
  Block* const vehicle = find(layout, kVehicle);
  if (vehicle == nullptr) return;
  const bool planar = is_pose(layout, vehicle->states);
  if (!planar && vehicle->states.size() != 1) return;
  if (planar) order_in_plane(layout, vehicle->states);
  const std::vector<Index> pose = vehicle->states;
  vehicle->part = planar ? Part::pose : Part::position;
  Block map{"all landmarks", Part::map, {}};
  for (Block& block : layout.blocks) {
    if (!block.name.starts_with("landmark") || block.states.size() != (planar ? 2U : 1U)) continue;
    block.part = Part::landmark;
    if (planar) order_in_plane(layout, block.states);
    map.states.insert(map.states.end(), block.states.begin(), block.states.end());
  }
  if (planar && find(layout, "position") == nullptr && find(layout, "heading") == nullptr) {
    layout.blocks.push_back({"position", Part::position, {pose[0], pose[1]}});
    layout.blocks.push_back({"heading", Part::heading, {pose[2]}});
  }
  if (map.states.empty()) return;
  layout.landmark_dim = planar ? 2 : 1;
  std::ranges::sort(map.states);
  leave_single_landmarks(layout.blocks);
  layout.blocks.push_back(std::move(map));
}

/// "" where it is not known.
std::string unit_of_state(const RunLayout& layout, Index state) {
  const auto i = static_cast<std::size_t>(state);
  if (i < layout.angles.size() && layout.angles[i]) return "rad";
  return i < layout.units.size() ? layout.units[i] : "";
}

}  // namespace

std::string unit_of_states(const RunLayout& layout, const std::vector<Index>& states) {
  if (states.empty()) return "";
  const std::string unit = unit_of_state(layout, states.front());
  const auto has_it = [&](Index state) { return unit_of_state(layout, state) == unit; };
  return std::ranges::all_of(states, has_it) ? unit : "";
}

std::string no_pose_sentence(const RunLayout& layout) {
  std::vector<Index> states;
  for (Index i = 0; i < std::ssize(layout.states); ++i) {
    if (block_of(layout.states[static_cast<std::size_t>(i)]) == kVehicle) states.push_back(i);
  }
  if (states.size() < 2 || is_pose(layout, states)) return {};
  return fmt::format(
      "vehicle.… are {} states, {} of them angles, and judged as one block: a pose, of which position and "
      "heading are judged too, has two states and one angle (x, y, heading:angle; other states under another "
      "name).",
      states.size(), angles_among(layout, states));
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

void add_named_blocks(RunLayout& layout) {
  std::unordered_map<std::string, std::size_t> places;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) places.emplace(layout.blocks[b].name, b);
  for (Index i = 0; i < std::ssize(layout.states); ++i) {
    const std::string name = block_of(layout.states[static_cast<std::size_t>(i)]);
    const auto [place, is_new] = places.emplace(name, layout.blocks.size());
    if (is_new) {
      layout.blocks.push_back({name, Part::other, {i}});
    } else {
      layout.blocks[place->second].states.push_back(i);
    }
  }
  name_parts(layout);
  add_units(layout);
}

}  // namespace credence
