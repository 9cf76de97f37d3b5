#include "montecarlo/worlds/spatial_slam/spatial_stream.h"

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_stream.h"
#include "montecarlo/worlds/spatial_slam/spatial_world.h"

namespace credence::internal {
namespace {

Vector pose_coordinates(const SE3& pose) { return pose.split().Log(); }

Vector odometry_numbers(const SpatialControl& read) {
  Vector numbers(6);
  numbers << read.v, read.omega;
  return numbers;
}

}  // namespace

WorldStream spatial_stream(const Scenario& scenario) {
  const SpatialWorld world = make_spatial_world(scenario);
  const auto play = [world, source = noise_source(scenario)](std::int64_t run, const RowVisitor& take) {
    SpatialSimulation simulation(world, source);
    take(0,
         {.prior = pose_coordinates(simulation.start(run)), .truth = pose_coordinates(world.path.front())});
    for (std::size_t k = 1; k < world.path.size(); ++k) {
      take(static_cast<std::int64_t>(k),
           {.truth = pose_coordinates(world.path[k]),
            .input = odometry_numbers(simulation.read(k)),
            .measurement = numbers_of_observations(simulation.observe(k), world.landmarks.size())});
    }
  };
  return {.states = {"position.x", "position.y", "position.z", "attitude.x", "attitude.y", "attitude.z"},
          .inputs = {"1", "2", "3", "4", "5", "6"},
          .measurements = names_of_landmarks(world.landmarks.size(), {"x", "y", "z"}),
          .notes =
              "state = SE(3): place p (m), attitude R = Exp of a rotation vector (rad)\n"
              "input = v (m), omega (rad): p + R v, R Exp(omega)\n" +
              text_of_landmarks(world.landmarks),
          .visit = play};
}

}  // namespace credence::internal
