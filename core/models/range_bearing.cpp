#include "core/models/range_bearing.h"

#include <cmath>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"

namespace credence::internal {

PredictedRangeBearing predict_range_bearing(const Pose& pose, const Point& landmark) {
  const double dx = landmark[0] - pose[0], dy = landmark[1] - pose[1];
  const double q = dx * dx + dy * dy, r = std::sqrt(q);
  PredictedRangeBearing p;
  p.z << r, wrap_angle(arc_tangent(dy, dx) - pose[2]);
  p.H_l << dx / r, dy / r, -dy / q, dx / q;
  p.H_r << -p.H_l, Eigen::Vector2d(0.0, -1.0);
  return p;
}

RangeBearing measure_range_bearing(const Pose& pose, const Point& landmark) {
  const double dx = landmark[0] - pose[0], dy = landmark[1] - pose[1];
  return {std::sqrt(dx * dx + dy * dy), wrap_angle(arc_tangent(dy, dx) - pose[2])};
}

PlacedLandmark place_landmark(const Pose& pose, const RangeBearing& z) {
  const auto [s, c] = sine_cosine(pose[2] + z[1]);
  PlacedLandmark p;
  p.position << pose[0] + z[0] * c, pose[1] + z[0] * s;
  p.J_r << 1, 0, -z[0] * s, 0, 1, z[0] * c;
  p.J_z << c, -z[0] * s, s, z[0] * c;
  return p;
}

RangeBearing range_bearing_innovation(const RangeBearing& z, const RangeBearing& predicted) {
  return {z[0] - predicted[0], wrap_angle(z[1] - predicted[1])};
}

}  // namespace credence::internal
