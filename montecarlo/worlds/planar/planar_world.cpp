#include "montecarlo/worlds/planar/planar_world.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/worlds/planar/path_length.h"

namespace credence::internal {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// A place on the path at arc length s of one loop, with the heading there.
Pose on_path(PathShape path, double radius, double s) {
  const double angle = s / radius;
  switch (path) {
    case PathShape::eight: {
      // The first circle is left of the origin's heading and driven anticlockwise, the second clockwise.
      const bool first = angle < kTwoPi;
      const double a = first ? angle : angle - kTwoPi;
      const double side = first ? 1.0 : -1.0;
      const auto [s_a, c_a] = sine_cosine(a);
      return {radius * s_a, side * radius * (1.0 - c_a), wrap_angle(side * a)};
    }
    case PathShape::line:
      return {s < 2.0 * radius ? s - radius : 3.0 * radius - s, 0.0,
              s < 2.0 * radius ? 0.0 : std::numbers::pi};
    case PathShape::circle: break;
  }
  const auto [sine_there, cosine_there] = sine_cosine(angle);
  return {radius * cosine_there, radius * sine_there, wrap_angle(angle + 0.5 * std::numbers::pi)};
}

/// Landmarks beside the path: the first of them near the start, so that the first are the natural anchors.
std::vector<Point> place_beside_path(PathShape path, double radius, Index count) {
  constexpr double kOffset = 0.3;  // of the radius, to either side
  const double length = path == PathShape::line ? 2.0 * radius : loop_length_m(path, radius);
  std::vector<Point> points;
  for (Index i = 0; i < count; ++i) {
    const double s = length * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const Pose pose = on_path(path, radius, s);
    const double side = (i % 2 == 0 ? 1.0 : -1.0) * kOffset * radius;
    points.emplace_back(pose[0] - side * sine(pose[2]), pose[1] + side * cosine(pose[2]));
  }
  return points;
}

double turn_rate_at(PathShape path, double radius, double speed, double s) {
  const double rate = speed / radius;
  if (path == PathShape::eight) return s < kTwoPi * radius ? rate : -rate;
  return path == PathShape::line ? 0.0 : rate;
}

std::vector<Control> nominal_controls(const Scenario& scenario, const Vehicle& vehicle) {
  const WorldSettings& w = scenario.world;
  const double length = loop_length_m(w.path, w.path_radius), step = w.speed * w.dt;
  std::vector<Control> controls;
  for (Index k = 0; k < scenario.study.steps; ++k) {
    const double s = std::fmod(static_cast<double>(k) * step, length);
    // The line is driven forth and, in reverse gear, back.
    const bool back = w.path == PathShape::line && s >= 2.0 * w.path_radius;
    Control u = vehicle.control_for(w.speed, turn_rate_at(w.path, w.path_radius, w.speed, s));
    if (back) u[0] = -u[0];
    if (!u.allFinite()) {
      throw std::invalid_argument(
          fmt::format("world.path_radius = {}: too tight for this vehicle, whose wheel base is {} m",
                      w.path_radius, vehicle.geometry.wheel_base));
    }
    controls.push_back(u);
  }
  return controls;
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

bool PlanarWorld::sees(const RangeBearing& z) const {
  return z[0] >= sensor_min_range_m && z[0] <= sensor_range_m && std::abs(z[1]) <= half_field_of_view_rad;
}

PlanarWorld make_planar_world(const Scenario& scenario) {
  const WorldSettings& w = scenario.world;
  PlanarWorld world;
  world.vehicle.kind = w.vehicle;
  world.dt_s = w.dt;
  world.sensor_min_range_m = w.sensor_min_range;
  world.sensor_range_m = w.sensor_range;
  world.half_field_of_view_rad = 0.5 * w.field_of_view_deg * kRadiansPerDegree;
  world.start = on_path(w.path, w.path_radius, 0.0);
  world.anchors = w.anchors;
  const std::vector<Point> points = place_beside_path(w.path, w.path_radius, w.landmarks + w.anchors);
  const auto first_state = points.begin() + w.anchors;
  world.landmarks.assign(first_state, points.end());
  world.landmarks.insert(world.landmarks.end(), points.begin(), first_state);
  world.controls = nominal_controls(scenario, world.vehicle);
  return world;
}

}  // namespace credence
