#include "montecarlo/worlds/planar_slam/odometry_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/filters/estimators/estimators.h"
#include "core/manifold/rotation.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/key_fields.h"

namespace credence::internal {
namespace {

std::vector<Point> place_on_ring(double radius, Index count) {
  std::vector<Point> points;
  for (Index i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    points.emplace_back(radius * cosine(angle), radius * sine(angle));
  }
  return points;
}

/// Evenly over the area between two circles.
std::vector<Point> draw_in_annulus(double inner, double outer, Index count, std::uint64_t map) {
  const NoiseSource source(map, 0);
  std::vector<Point> points;
  for (Index i = 0; i < count; ++i) {
    const double share = source.uniform(0, 1, NoisePurpose::world, 2 * i);
    const double angle = 2.0 * std::numbers::pi * source.uniform(0, 1, NoisePurpose::world, 2 * i + 1);
    const double radius = std::sqrt(inner * inner + share * (outer * outer - inner * inner));
    points.emplace_back(radius * cosine(angle), radius * sine(angle));
  }
  return points;
}

std::vector<Point> landmarks_of(const Scenario& scenario) {
  const double radius = scenario.world.path_radius;
  const Index count = scenario.world.landmarks;
  if (has_landmark_ring(scenario))
    return place_on_ring(radius + real_value(scenario, "world.ring_offset"), count);
  const double half = real_value(scenario, "world.annulus_half_width");
  return draw_in_annulus(std::max(0.0, radius - half), radius + half, count,
                         static_cast<std::uint64_t>(integer_value(scenario, "world.map")));
}

std::vector<Observation<PlanarModel>> seen_from(const Pose& pose, const OdometryWorld& world) {
  std::vector<Observation<PlanarModel>> seen;
  for (std::size_t i = 0; i < world.plane.landmarks.size(); ++i) {
    const Point& l = world.plane.landmarks[i];
    if (!world.plane.sees(measure_range_bearing(pose, l))) continue;
    const Eigen::Vector2d rho = rotation(pose[2]).transpose() * (l - pose.head<2>());
    seen.push_back({static_cast<int>(i), world.sensor.measure(rho)});
  }
  return seen;
}

}  // namespace

bool has_landmark_ring(const Scenario& scenario) {
  return word_value(scenario, "world.landmark_layout") == "ring";
}

bool measures_relative_position(const Scenario& scenario) {
  return word_value(scenario, "world.landmark_sensor") == "relative_position";
}

OdometryWorld make_odometry_world(const Scenario& scenario) {
  OdometryWorld world;
  world.plane = make_planar_world(scenario);
  world.plane.landmarks = landmarks_of(scenario);
  world.path.push_back(world.plane.start);
  for (const Control& u : world.plane.controls) {
    world.path.push_back(world.plane.vehicle.moved(world.path.back(), u, world.plane.dt_s));
  }
  world.noise = PlanarNoise::of(scenario);
  world.sensor.kind = LandmarkSensorKind::range_bearing;
  if (measures_relative_position(scenario)) {
    world.sensor.kind = LandmarkSensorKind::relative_position;
    world.noise.measurement_std.setConstant(real_value(scenario, "noise.relative_position_std"));
  }
  for (const Pose& pose : world.path) world.in_view.push_back(seen_from(pose, world));
  world.width_m = 2.0 * scenario.world.path_radius;
  for (const Point& p : world.plane.landmarks) world.width_m = std::max(world.width_m, 2.0 * p.norm());
  return world;
}

EstimatorSettings estimator_settings(const Scenario& scenario, const OdometryWorld& world) {
  EstimatorSettings settings;
  settings.model = {.vehicle = world.plane.vehicle, .dt_s = world.plane.dt_s};
  settings.sensor = world.sensor;
  settings.Q = (scenario.filter.process_scale * world.noise.control_std.cwiseAbs2()).asDiagonal();
  settings.R = (scenario.filter.measurement_scale * world.noise.measurement_std.cwiseAbs2()).asDiagonal();
  settings.landmarks = world.plane.states();
  settings.sigma_spread = real_value(scenario, "filter.sigma_spread");
  settings.window = static_cast<Index>(integer_value(scenario, "filter.window"));
  settings.active_sights = static_cast<Index>(integer_value(scenario, "filter.active_sights"));
  return settings;
}

std::unique_ptr<SlamEstimator> scenario_estimator(const Scenario& scenario, const OdometryWorld& world) {
  return scenario_estimator(scenario, world, word_value(scenario, "filter.estimator"));
}

std::unique_ptr<SlamEstimator> scenario_estimator(const Scenario& scenario, const OdometryWorld& world,
                                                  std::string_view name) {
  return make_estimator(name, estimator_settings(scenario, world));
}

}  // namespace credence::internal
