#include "montecarlo/worlds/slam_layout.h"

#include <fmt/format.h>

namespace credence::internal {
namespace {

constexpr Index kPose = 3;

void add_vehicle(bool planar, RunLayout& layout) {
  if (!planar) {
    layout.states = {"vehicle"};
    layout.blocks = {{"vehicle", Part::position, {0}}};
    return;
  }
  layout.states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  layout.blocks = {
      {"pose", Part::pose, {0, 1, 2}}, {"position", Part::position, {0, 1}}, {"heading", Part::heading, {2}}};
}

void add_landmarks(const BlockLayout& blocks, RunLayout& layout) {
  Block map{"all landmarks", Part::map, {}};
  for (Index i = 0; i < blocks.landmarks; ++i) {
    Block landmark{fmt::format("landmark {}", i + 1), Part::landmark, {}};
    for (Index axis = 0; axis < blocks.landmark; ++axis) {
      landmark.states.push_back(std::ssize(layout.states));
      map.states.push_back(std::ssize(layout.states));
      const char* const name = axis == 0 ? ".x" : ".y";
      layout.states.push_back(fmt::format("landmark{}{}", i + 1, blocks.landmark == 1 ? "" : name));
    }
    if (i < kSingleLandmarks) layout.blocks.push_back(std::move(landmark));
  }
  layout.landmark_dim = blocks.landmark;
  if (blocks.landmarks > 0) layout.blocks.push_back(std::move(map));
}

}  // namespace

RunLayout slam_layout(const BlockLayout& blocks, Index measurements, bool constant) {
  constexpr Index kLargestWhole = 4;
  RunLayout layout;
  const bool planar = blocks.vehicle == kPose;
  add_vehicle(planar, layout);
  add_landmarks(blocks, layout);
  layout.angles.assign(layout.states.size(), false);
  layout.units.assign(layout.states.size(), "m");
  if (planar) {
    layout.angles[2] = true;
    layout.units[2] = "rad";
  }
  layout.nonlinear = planar;
  const Index piece = constant && measurements <= kLargestWhole ? measurements : blocks.landmark;
  layout.sensors = {{.name = "", .dim = measurements, .piece = piece}};
  return layout;
}

void slam_states(const BlockLayout& blocks, std::span<const int> landmarks, std::vector<Index>& states) {
  states.clear();
  for (Index i = 0; i < blocks.vehicle; ++i) states.push_back(i);
  for (const int landmark : landmarks) {
    for (Index axis = 0; axis < blocks.landmark; ++axis) {
      states.push_back(blocks.vehicle + blocks.landmark * landmark + axis);
    }
  }
}

}  // namespace credence::internal
