#include "montecarlo/worlds/planar/planar_simulation.h"

#include <cmath>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/state_error.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence {

using namespace internal;

PlanarNoise PlanarNoise::of(const Scenario& scenario) {
  const NoiseSettings& n = scenario.noise;
  const double turn_std = scenario.world.vehicle == VehicleKind::unicycle
                              ? n.turn_rate_std
                              : n.steering_std_deg * kRadiansPerDegree;
  const InitialSettings& i = scenario.initial;
  return {.control_std = {n.speed_std, turn_std},
          .measurement_std = {n.range_std, n.bearing_std_deg * kRadiansPerDegree},
          .initial_std = {i.position_std, i.position_std, i.heading_std_deg * kRadiansPerDegree},
          .detection_probability = n.detection_probability,
          .measurement_delay = credence::internal::measurement_delay(scenario)};
}

}  // namespace credence

namespace credence::internal {

PlanarSimulation::PlanarSimulation(const PlanarWorld& world, const PlanarNoise& noise,
                                   std::optional<NoiseSource> source)
    : world_(world),
      noise_(noise),
      source_(source),
      pose_(world.start),
      draws_(source, 2, 2, std::ssize(world.landmarks), noise.detection_probability,
             noise.measurement_delay) {}

Pose PlanarSimulation::start(std::int64_t run) {
  pose_ = world_.start;
  draws_.start(run);
  Pose error = Pose::Zero();
  if (source_) source_->normals(run, 0, NoisePurpose::initial, {error.data(), 3});
  Pose estimate = pose_ + error.cwiseProduct(noise_.initial_std);
  estimate[2] = wrap_angle(estimate[2]);
  return estimate;
}

void PlanarSimulation::move(std::size_t k) {
  const Control noise(draws_.motion(k));
  const Control u = world_.controls[k - 1] + noise.cwiseProduct(noise_.control_std);
  pose_ = world_.vehicle.moved(pose_, u, world_.dt_s);
}

void PlanarSimulation::find_in_range(const double* detected) {
  InRange& in = in_range_;
  in.landmark.clear();
  in.dx.clear();
  in.dy.clear();
  const double reach = world_.sensor_range_m * world_.sensor_range_m * (1.0 + 1e-12);  // sees() decides
  for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
    const double dx = world_.landmarks[i][0] - pose_[0], dy = world_.landmarks[i][1] - pose_[1];
    if (detected[i] == 0.0 || dx * dx + dy * dy > reach) continue;
    in.landmark.push_back(i);
    in.dx.push_back(dx);
    in.dy.push_back(dy);
  }
  in.direction.resize(in.dx.size());
  arc_tangents(in.dy.data(), in.dx.data(), in.direction.data(), in.dx.size());
}

std::span<const Observation<PlanarModel>> PlanarSimulation::observe(std::size_t k) {
  const double* noise = draws_.measurement(k);
  find_in_range(draws_.detection(k));
  return draws_.in_time([&](auto& observations) {
    for (std::size_t n = 0; n < in_range_.landmark.size(); ++n) {
      const std::size_t i = in_range_.landmark[n];
      RangeBearing z(std::sqrt(in_range_.dx[n] * in_range_.dx[n] + in_range_.dy[n] * in_range_.dy[n]),
                     wrap_angle(in_range_.direction[n] - pose_[2]));
      if (!world_.sees(z)) continue;
      z[0] += noise_.measurement_std[0] * noise[2 * i];
      z[1] = wrap_angle(z[1] + noise_.measurement_std[1] * noise[2 * i + 1]);
      observations.push_back({static_cast<int>(i), z});
    }
  });
}

BlockLayout planar_blocks(const PlanarWorld& world) {
  return {.vehicle = 3, .landmark = 2, .landmarks = world.states()};
}

RunLayout planar_layout(const PlanarWorld& world) {
  RunLayout layout = slam_layout(planar_blocks(world), 2 * std::ssize(world.landmarks), false);
  layout.sensors.front().angles = {false, true};  // range, bearing
  return layout;
}

void record_planar_error(const Pose& pose, const PlanarWorld& world, TraceStep& step) {
  step.truth = true_state(pose, world.landmarks, step.landmarks);
  step.error = step.estimate - step.truth;
  step.error[2] = wrap_angle(step.error[2]);
  slam_states(planar_blocks(world), step.landmarks, step.states);
}

RunTrace describe_planar_world(const PlanarWorld& world) {
  RunTrace trace;
  trace.landmark_positions.resize(2, world.states());
  trace.anchor_positions.resize(2, world.anchors);
  for (Index i = 0; i < world.states() + world.anchors; ++i) {
    const Point& p = world.landmarks[static_cast<std::size_t>(i)];
    if (i < world.states()) {
      trace.landmark_positions.col(i) = p;
    } else {
      trace.anchor_positions.col(i - world.states()) = p;
    }
  }
  return trace;
}

}  // namespace credence::internal
