#include "montecarlo/worlds/planar_slam/odometry_simulation.h"

#include "core/manifold/angle.h"

namespace credence::internal {

OdometrySimulation::OdometrySimulation(const OdometryWorld& world, const NoiseSource& source)
    : world_(world),
      source_(source),
      draws_(source, 2, 2, world.plane.states(), world.noise.detection_probability,
             world.noise.measurement_delay) {}

Pose OdometrySimulation::start(std::int64_t run) {
  draws_.start(run);
  Pose error;
  source_.normals(run, 0, NoisePurpose::initial, {error.data(), 3});
  Pose estimate = world_.path.front() + error.cwiseProduct(world_.noise.initial_std);
  estimate[2] = wrap_angle(estimate[2]);
  return estimate;
}

Control OdometrySimulation::read(std::size_t k) {
  const Control noise(draws_.motion(k));
  return world_.plane.controls[k - 1] + noise.cwiseProduct(world_.noise.control_std);
}

std::span<const Observation<PlanarModel>> OdometrySimulation::observe(std::size_t k) {
  const double* noise = draws_.measurement(k);
  const double* seen = draws_.detection(k);
  return draws_.in_time([&](auto& observations) {
    for (const Observation<PlanarModel>& exact : world_.in_view[k]) {
      const auto i = static_cast<std::size_t>(exact.landmark);
      if (seen[i] == 0.0) continue;
      Eigen::Vector2d z = exact.z;
      z += world_.noise.measurement_std.cwiseProduct(Eigen::Map<const Eigen::Vector2d>(noise + 2 * i));
      if (world_.sensor.kind == LandmarkSensorKind::range_bearing) z[1] = wrap_angle(z[1]);
      observations.push_back({exact.landmark, z});
    }
  });
}

}  // namespace credence::internal
