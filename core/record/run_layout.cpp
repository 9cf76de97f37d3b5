#include "core/record/run_layout.h"

#include <algorithm>

namespace credence {
namespace {

std::string block_of(const std::string& state) { return state.substr(0, state.find('.')); }

bool is_pose(const RunLayout& layout, const std::vector<Index>& states) {
  return states.size() == 3 && states[1] == states[0] + 1 && states[2] == states[0] + 2 &&
         layout.angles[static_cast<std::size_t>(states[2])];
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

/// Names the parts of a vehicle and a map, where the blocks are such.
void name_parts(RunLayout& layout) {
  Block* const vehicle = find(layout, "vehicle");
  if (vehicle == nullptr) return;
  const std::vector<Index> pose = vehicle->states;
  const bool planar = is_pose(layout, pose);
  if (!planar && pose.size() != 1) return;
  vehicle->part = planar ? Part::pose : Part::position;
  Block map{"all landmarks", Part::map, {}};
  for (Block& block : layout.blocks) {
    if (!block.name.starts_with("landmark") || block.states.size() != (planar ? 2U : 1U)) continue;
    block.part = Part::landmark;
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

}  // namespace

void add_named_blocks(RunLayout& layout) {
  for (Index i = 0; i < std::ssize(layout.states); ++i) {
    const std::string name = block_of(layout.states[static_cast<std::size_t>(i)]);
    Block* const block = find(layout, name);
    if (block == nullptr) {
      layout.blocks.push_back({name, Part::other, {i}});
    } else {
      block->states.push_back(i);
    }
  }
  name_parts(layout);
}

}  // namespace credence
