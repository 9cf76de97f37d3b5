#include "montecarlo/planar_experiment.h"

#include "montecarlo/filter_setup.h"

namespace credence {

AssumedPlanarNoise AssumedPlanarNoise::of(const Scenario& scenario) {
  const PlanarNoise noise = PlanarNoise::of(scenario);
  return {.Q = (scenario.filter.process_scale * noise.control_std.cwiseAbs2()).asDiagonal(),
          .measurement_variance = scenario.filter.measurement_scale * noise.measurement_std.cwiseAbs2()};
}

EkfSlam<PlanarModel> make_planar_filter(const Scenario& scenario, const PlanarWorld& world) {
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
  const Eigen::Matrix2d R = assumed.measurement_variance.asDiagonal();
  std::vector<Anchor<PlanarModel>> anchors;
  for (Index i = world.states(); i < world.states() + world.anchors; ++i) {
    anchors.push_back({static_cast<int>(i), world.landmarks[static_cast<std::size_t>(i)]});
  }
  return EkfSlam<PlanarModel>({.vehicle = world.vehicle, .dt_s = world.dt_s}, assumed.Q, R,
                              make_inflation_rule(scenario), anchors);
}

}  // namespace credence
