#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/plugged/model_plug.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"

/// @file
/// Worlds of scenarios that are plugged: what the scenario says of any of them.

namespace credence::internal {

/// Steps, seed and noise of a scenario, with the switches of [noise].
PlugSettings plug_settings(const Scenario& scenario);

/// A world of which a step is measured with probability `detection`, else missed as a whole.
class MissingWorld : public FunctionWorld {
 public:
  MissingWorld(FunctionWorld world, double detection)
      : FunctionWorld(std::move(world)), detection_(detection) {}

  std::optional<Vector> measure(const Vector& x, std::int64_t k, NoiseDraw& noise) const {
    Vector z = FunctionWorld::measure(x, k, noise);
    if (detection_ < 1.0 && noise.uniform() >= detection_) return std::nullopt;
    return z;
  }

 private:
  double detection_;
};

template <PluggedWorld World, class MakeFilter>
std::unique_ptr<Experiment> plugged_experiment(World world, MakeFilter make_filter,
                                               const PlugSettings& settings) {
  return std::make_unique<PluggedExperiment<World, MakeFilter>>(std::move(world), std::move(make_filter),
                                                                settings);
}

}  // namespace credence::internal
