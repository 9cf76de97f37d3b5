#include "montecarlo/worlds/planar_slam/odometry_stream.h"

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_stream.h"
#include "montecarlo/worlds/planar_slam/odometry_simulation.h"

namespace credence::internal {

WorldStream odometry_stream(const Scenario& scenario) {
  const OdometryWorld world = make_odometry_world(scenario);
  const auto play = [world, source = noise_source(scenario)](std::int64_t run, const RowVisitor& take) {
    OdometrySimulation simulation(world, source);
    take(0, {.prior = simulation.start(run), .truth = world.path.front()});
    for (std::size_t k = 1; k < world.path.size(); ++k) {
      take(static_cast<std::int64_t>(k),
           {.truth = world.path[k],
            .input = simulation.read(k),
            .measurement = numbers_of_observations(simulation.observe(k), world.plane.landmarks.size())});
    }
  };
  const bool relative = world.sensor.kind != LandmarkSensorKind::range_bearing;
  return {.states = {"vehicle.x", "vehicle.y", "vehicle.heading"},
          .inputs = {"1", "2"},
          .measurements = names_of_landmarks(
              world.plane.landmarks.size(),
              relative ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"range", "bearing"}),
          .notes = text_of_landmarks(world.plane.landmarks),
          .visit = play};
}

}  // namespace credence::internal
