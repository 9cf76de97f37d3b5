#pragma once

#include <span>

#include "core/nan.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {

/// A vehicle in the plane: nominal controls, and range (m) and bearing (rad) of the landmarks in view. Throws
/// as make_planar_world does.
WorldStream planar_stream(const Scenario& scenario);

/// Each at the numbers of its landmark; empty where nothing is seen.
template <class Observation>
Vector numbers_of_observations(std::span<const Observation> seen, std::size_t landmarks) {
  if (seen.empty()) return {};
  const Index dim = seen.front().z.size();
  Vector z = Vector::Constant(dim * static_cast<Index>(landmarks), kNaN);
  for (const Observation& one : seen) z.segment(dim * Index{one.landmark}, dim) = one.z;
  return z;
}

}  // namespace credence::internal
