#include "montecarlo/worlds/monobot/linear_world.h"

#include <numeric>

namespace credence {

Vector linear_start(const BlockLayout& layout) {
  Vector x = Vector::Constant(layout.state_dim(), 1.0);
  x[0] = -1.0;
  for (Index i = 0; i < layout.landmarks; ++i) {
    x[1 + i] += 0.5 * (static_cast<double>(i) - 0.5 * static_cast<double>(layout.landmarks - 1));
  }
  return x;
}

RunTrace describe_linear_world(const LinearModel& model) {
  const BlockLayout& layout = model.layout;
  return {.landmark_positions = linear_start(layout).tail(layout.landmarks).transpose(),
          .anchor_positions = Matrix::Zero(1, model.measurement_dim() - layout.landmarks)};
}

std::vector<int> linear_landmarks(const BlockLayout& layout) {
  std::vector<int> landmarks(static_cast<std::size_t>(layout.landmarks));
  std::iota(landmarks.begin(), landmarks.end(), 0);
  return landmarks;
}

}  // namespace credence
