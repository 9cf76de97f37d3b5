#include "montecarlo/worlds/planar_slam/odometry_drive.h"

#include "core/manifold/angle.h"

namespace credence {

OdometryDrive::OdometryDrive(const OdometryWorld& world, const NoiseSource& source)
    : world_(world),
      source_(source),
      process_(StepDraws::normals(source, NoisePurpose::process, 2)),
      measurement_(StepDraws::normals(source, NoisePurpose::measurement, 2 * world.plane.states())),
      detection_(StepDraws::events(source, NoisePurpose::detection, world.detection_probability,
                                   world.plane.states())),
      line_(world.measurement_delay) {
  observations_.reserve(world.plane.landmarks.size());
}

Pose OdometryDrive::start(std::int64_t run) {
  line_.clear();
  for (StepDraws* draws : {&process_, &measurement_, &detection_}) draws->start(run);
  Pose error;
  source_.normals(run, 0, NoisePurpose::initial, {error.data(), 3});
  Pose estimate = world_.path.front() + error.cwiseProduct(world_.initial_std);
  estimate[2] = wrap_angle(estimate[2]);
  return estimate;
}

Control OdometryDrive::read(std::size_t k) {
  const Control noise(process_.at(static_cast<Index>(k)));
  return world_.plane.controls[k - 1] + noise.cwiseProduct(world_.control_std);
}

std::span<const Observation<PlanarModel>> OdometryDrive::observe(std::size_t k) {
  const double* noise = measurement_.at(static_cast<Index>(k));
  const double* seen = detection_.at(static_cast<Index>(k));
  observations_.clear();
  for (const Observation<PlanarModel>& exact : world_.in_view[k]) {
    const auto i = static_cast<std::size_t>(exact.landmark);
    if (seen[i] == 0.0) continue;
    Eigen::Vector2d z = exact.z;
    z += world_.measurement_std.cwiseProduct(Eigen::Map<const Eigen::Vector2d>(noise + 2 * i));
    if (world_.sensor.kind == LandmarkSensorKind::range_bearing) z[1] = wrap_angle(z[1]);
    observations_.push_back({exact.landmark, z});
  }
  if (world_.measurement_delay > 0) {
    observations_ = line_.pass(observations_).value_or(std::vector<Observation<PlanarModel>>{});
  }
  return observations_;
}

}  // namespace credence
