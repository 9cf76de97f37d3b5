#include "montecarlo/planar_experiment.h"

#include "montecarlo/filter_setup.h"

namespace credence {

EkfSlam<PlanarModel> make_planar_filter(const Scenario& scenario, const PlanarWorld& world) {
  const PlanarNoise noise = PlanarNoise::of(scenario);
  const Eigen::Matrix2d Q = (scenario.filter.process_scale * noise.control_std.cwiseAbs2()).asDiagonal();
  const Eigen::Matrix2d R =
      (scenario.filter.measurement_scale * noise.measurement_std.cwiseAbs2()).asDiagonal();
  std::vector<Anchor<PlanarModel>> anchors;
  for (Index i = world.states(); i < world.states() + world.anchors; ++i) {
    anchors.push_back({static_cast<int>(i), world.landmarks[static_cast<std::size_t>(i)]});
  }
  return EkfSlam<PlanarModel>({.vehicle = world.vehicle, .dt_s = world.dt_s}, Q, R,
                              make_inflation_rule(scenario), anchors);
}

}  // namespace credence
