#include "montecarlo/worlds/linear/linear_trace.h"

#include <numeric>

namespace credence::internal {

Vector linear_start(const LinearScene& scene, VectorRef error) {
  if (!scene.random_start) return scene.start;
  return scene.start + error;
}

void name_states(const BlockLayout& layout, TraceStep& step) {
  step.landmarks.resize(static_cast<std::size_t>(layout.landmarks));
  std::iota(step.landmarks.begin(), step.landmarks.end(), 0);
  step.states.resize(static_cast<std::size_t>(layout.state_dim()));
  std::iota(step.states.begin(), step.states.end(), Index{0});
}

void set_error(const Vector& x, VectorRef error, TraceStep& step) {
  step.truth = x;
  step.error = -error;
  step.estimate = x - error;
}

RunTrace describe_scene(const LinearScene& scene) {
  return {.landmark_positions = scene.landmark_positions, .anchor_positions = scene.anchor_positions};
}

}  // namespace credence::internal
