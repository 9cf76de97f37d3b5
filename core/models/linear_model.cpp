#include "core/models/linear_model.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

void require_variance(const char* name, double value) {
  if (!(std::isfinite(value) && value >= 0.0)) {
    throw std::invalid_argument(fmt::format("{} = {} must be a finite number >= 0", name, value));
  }
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

LinearModel monobot_model(Index landmarks, Index anchors, double process_variance,
                          double measurement_variance, double initial_variance) {
  if (landmarks < 0 || anchors < 0 || landmarks + anchors < 1) {
    throw std::invalid_argument(fmt::format(
        "landmarks = {}, anchors = {}: the monobot needs at least one to measure", landmarks, anchors));
  }
  require_variance("process_variance", process_variance);
  require_variance("measurement_variance", measurement_variance);
  require_variance("initial_variance", initial_variance);

  const Index n = 1 + landmarks;
  const Index m = anchors + landmarks;
  LinearModel model;
  model.layout = {.vehicle = 1, .landmark = 1, .landmarks = landmarks};
  model.F = Matrix::Identity(n, n);
  model.G = Matrix::Identity(n, 1);
  model.Q = Matrix::Constant(1, 1, process_variance);
  model.H = Matrix::Zero(m, n);
  model.H.col(0).setConstant(-1.0);
  model.H.bottomRightCorner(landmarks, landmarks).setIdentity();
  model.R = measurement_variance * Matrix::Identity(m, m);
  model.P0 = initial_variance * Matrix::Identity(n, n);
  return model;
}

}  // namespace credence
