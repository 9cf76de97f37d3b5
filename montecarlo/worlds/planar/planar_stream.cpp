#include "montecarlo/worlds/planar/planar_stream.h"

#include "montecarlo/scenario/noise_switches.h"

namespace credence::internal {

WorldStream planar_stream(const Scenario& scenario) {
  const PlanarWorld world = make_planar_world(scenario);
  const auto play = [world, noise = PlanarNoise::of(scenario), source = noise_source(scenario)](
                        std::int64_t run, const RowVisitor& take) {
    PlanarSimulation simulation(world, noise, source);
    const Pose prior = simulation.start(run);
    take(0, {.prior = prior, .truth = simulation.pose()});
    for (std::size_t k = 1; k <= world.controls.size(); ++k) {
      simulation.move(k);
      take(static_cast<std::int64_t>(k),
           {.truth = simulation.pose(),
            .input = world.controls[k - 1],
            .measurement = numbers_of_observations(simulation.observe(k), world.landmarks.size())});
    }
  };
  return {.states = {"vehicle.x", "vehicle.y", "vehicle.heading"},
          .inputs = {"1", "2"},
          .measurements = names_of_landmarks(world.landmarks.size(), {"range", "bearing"}),
          .notes = text_of_landmarks(world.landmarks),
          .visit = play};
}

}  // namespace credence::internal
