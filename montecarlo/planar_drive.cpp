#include "montecarlo/planar_drive.h"

#include "core/angle.h"

namespace credence {

PlanarNoise PlanarNoise::of(const Scenario& scenario) {
  const NoiseSettings& n = scenario.noise;
  const double turn_std = scenario.world.vehicle == VehicleKind::unicycle
                              ? n.turn_rate_std
                              : n.steering_std_deg * kRadiansPerDegree;
  const InitialSettings& i = scenario.initial;
  return {.control_std = {n.speed_std, turn_std},
          .measurement_std = {n.range_std, n.bearing_std_deg * kRadiansPerDegree},
          .initial_std = {i.position_std, i.position_std, i.heading_std_deg * kRadiansPerDegree},
          .detection_probability = n.detection_probability};
}

PlanarDrive::PlanarDrive(const PlanarWorld& world, const PlanarNoise& noise,
                         std::optional<NoiseSource> source)
    : world_(world),
      noise_(noise),
      source_(source),
      pose_(world.start),
      process_{NoisePurpose::process, 2, std::vector<double>(8)},
      measurement_{NoisePurpose::measurement, 2 * std::ssize(world.landmarks),
                   std::vector<double>(8 * world.landmarks.size())},
      detection_{NoisePurpose::detection, std::ssize(world.landmarks),
                 std::vector<double>(4 * world.landmarks.size(), 1.0)} {
  observations_.reserve(world.landmarks.size());
}

const double* PlanarDrive::draw(std::size_t k, Draws& draws) const {
  const std::size_t first = k - (k - 1) % 4;
  if (source_ && draws.first_step != first) {
    source_->normals_of_four_steps(run_, static_cast<std::int64_t>(first), draws.purpose, draws.slots,
                                   draws.values);
    draws.first_step = first;
  }
  return draws.values.data() + (k - first) * static_cast<std::size_t>(draws.slots);
}

const double* PlanarDrive::draw_detections(std::size_t k) {
  const std::size_t first = k - (k - 1) % 4;
  if (source_ && noise_.detection_probability < 1.0 && detection_.first_step != first) {
    source_->events_of_four_steps(run_, static_cast<std::int64_t>(first), detection_.purpose,
                                  noise_.detection_probability, detection_.slots, detection_.values);
    detection_.first_step = first;
  }
  return detection_.values.data() + (k - first) * static_cast<std::size_t>(detection_.slots);
}

Pose PlanarDrive::start(std::int64_t run) {
  run_ = run;
  pose_ = world_.start;
  process_.first_step = measurement_.first_step = detection_.first_step = 0;
  Pose error = Pose::Zero();
  if (source_) source_->normals(run, 0, NoisePurpose::initial, {error.data(), 3});
  Pose estimate = pose_ + error.cwiseProduct(noise_.initial_std);
  estimate[2] = wrap_angle(estimate[2]);
  return estimate;
}

void PlanarDrive::move(std::size_t k) {
  const Control noise(draw(k, process_));
  const Control u = world_.controls[k - 1] + noise.cwiseProduct(noise_.control_std);
  pose_ = world_.vehicle.moved(pose_, u, world_.dt_s);
}

std::span<const Observation<PlanarModel>> PlanarDrive::observe(std::size_t k) {
  const double *noise = draw(k, measurement_), *seen = draw_detections(k);
  observations_.clear();
  for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
    RangeBearing z = measure_range_bearing(pose_, world_.landmarks[i]);
    if (seen[i] == 0.0 || !world_.sees(z)) continue;
    z[0] += noise_.measurement_std[0] * noise[2 * i];
    z[1] = wrap_angle(z[1] + noise_.measurement_std[1] * noise[2 * i + 1]);
    observations_.push_back({static_cast<int>(i), z});
  }
  return observations_;
}

RunTrace describe_planar_world(const PlanarWorld& world) {
  RunTrace trace{.vehicle_dim = 3, .landmark_dim = 2};
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

}  // namespace credence
