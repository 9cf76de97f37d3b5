#include "montecarlo/worlds/planar/planar_experiment.h"

#include <stdexcept>

#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {

AssumedPlanarNoise AssumedPlanarNoise::of(const Scenario& scenario) {
  const PlanarNoise noise = PlanarNoise::of(scenario);
  return {.Q = (scenario.filter.process_scale * noise.control_std.cwiseAbs2()).asDiagonal(),
          .measurement_variance = scenario.filter.measurement_scale * noise.measurement_std.cwiseAbs2()};
}

namespace {

/// What a filter of the scenario assumes.
struct Assumptions {
  PlanarModel model;
  Eigen::Matrix2d Q, R;
  std::vector<Anchor<PlanarModel>> anchors;

  Assumptions(const Scenario& scenario, const PlanarWorld& world)
      : model{.vehicle = world.vehicle, .dt_s = world.dt_s} {
    const AssumedPlanarNoise noise = AssumedPlanarNoise::of(scenario);
    Q = noise.Q;
    R = noise.measurement_variance.asDiagonal();
    for (Index i = world.states(); i < world.states() + world.anchors; ++i) {
      anchors.push_back({static_cast<int>(i), world.landmarks[static_cast<std::size_t>(i)]});
    }
  }
};

}  // namespace

bool has_block_map(const Scenario& scenario) {
  return scenario.filter.inflation == FilterInflation::map && make_inflation_rule(scenario).is_sequential();
}

BlockMapEkfSlam<PlanarModel> make_block_map_filter(const Scenario& scenario, const PlanarWorld& world) {
  if (!has_block_map(scenario)) {
    throw std::invalid_argument("the scenario's filter has no block diagonal map");
  }
  const Assumptions a(scenario, world);
  return {a.model, a.Q, a.R, *make_inflation_rule(scenario).map_bound(), a.anchors};
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

EkfSlam<PlanarModel> make_planar_filter(const Scenario& scenario, const PlanarWorld& world) {
  const Assumptions a(scenario, world);
  return {a.model, a.Q, a.R, make_inflation_rule(scenario), a.anchors};
}

}  // namespace credence
