#include "montecarlo/worlds/planar_slam/odometry_stream.h"

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_stream.h"
#include "montecarlo/worlds/planar_slam/odometry_drive.h"

namespace credence {

OdometryStream::OdometryStream(const Scenario& scenario)
    : world_(make_odometry_world(scenario)), source_(noise_source(scenario)) {
  states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  inputs = {"1", "2"};
  const bool relative = world_.sensor.kind != LandmarkSensorKind::range_bearing;
  measurements = names_of_landmarks(
      world_.plane.landmarks.size(),
      relative ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"range", "bearing"});
  notes = text_of_landmarks(world_.plane.landmarks);
}

void OdometryStream::visit(std::int64_t run,
                           const std::function<void(std::int64_t, const StreamRow&)>& take) const {
  OdometryDrive drive(world_, source_);
  const Pose prior = drive.start(run);
  const std::size_t landmarks = world_.plane.landmarks.size();
  take(0, {.prior = prior, .truth = world_.path.front()});
  for (std::size_t k = 1; k < world_.path.size(); ++k) {
    take(static_cast<std::int64_t>(k), {.truth = world_.path[k],
                                        .input = drive.read(k),
                                        .measurement = numbers_of_observations(drive.observe(k), landmarks)});
  }
}

}  // namespace credence
