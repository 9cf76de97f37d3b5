#include "datasets/logs/conventions/pose_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "core/append_item.h"

namespace credence {

using namespace internal;

PoseCovariance PoseChart::position_first(const PoseCovariance& written) const {
  if (!rotation_first) return written;
  PoseCovariance P;
  P << written.bottomRightCorner<3, 3>(), written.bottomLeftCorner<3, 3>(), written.topRightCorner<3, 3>(),
      written.topLeftCorner<3, 3>();
  return P;
}

std::span<const PoseChart> pose_charts() {
  using enum OrientationError;
  static constexpr PoseChart charts[] = {
      {"ros", "position, rotation about the fixed axes", kFixedAxes},
      {"body", "position in the world, rotation R = R̂ Exp(e)", {.orientation = body}},
      {"rpy", "position in the world, roll, pitch and yaw", {.orientation = rpy}},
      {"planar", "x, y and yaw", {.orientation = planar}},
      {"gtsam", "rotation before translation, T = T̂ Exp(e)", {PositionError::twist, body}, true},
      {"sophus", "translation, rotation, T = T̂ Exp(e)", {PositionError::twist, body}},
      {"manif", "translation, rotation, T = T̂ Exp(e)", {PositionError::twist, body}},
      {"left", "translation, rotation, T = Exp(e) T̂", {PositionError::twist, world}},
      {"g2o",
       "translation in the body, vector part of a quaternion on the right: half angles",
       {PositionError::body, body, RotationUnit::quaternion_part}},
      {"ceres",
       "position in the world, quaternion perturbed on the left: half angles",
       {PositionError::world, world, RotationUnit::half_vector}},
  };
  return charts;
}

const PoseChart& pose_chart_named(std::string_view name) {
  const auto found = std::ranges::find(pose_charts(), name, &PoseChart::name);
  if (found != pose_charts().end()) return *found;
  std::string names;
  for (const PoseChart& chart : pose_charts()) {
    append_item(names, fmt::format("{} ({})", chart.name, chart.says));
  }
  throw std::invalid_argument(fmt::format("--chart {}: accepted are {}", name, names));
}

const PoseChart& pose_chart_of(OrientationError orientation) {
  return *std::ranges::find(pose_charts(), PoseErrorAxes{.orientation = orientation}, &PoseChart::axes);
}

}  // namespace credence
