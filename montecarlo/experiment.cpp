#include "montecarlo/experiment.h"

#include "montecarlo/filter_setup.h"
#include "montecarlo/linear_experiment.h"
#include "montecarlo/planar_experiment.h"
#include "montecarlo/planar_lanes_experiment.h"
#include "montecarlo/scenario_text.h"

namespace credence {

RunTrace Experiment::trace(std::int64_t run) const {
  RunTrace trace = describe_world();
  trace.run = run;
  trace.outcome = visit(run, [&](const TraceStep& step) { trace.steps.push_back(step); });
  return trace;
}

std::unique_ptr<Experiment> make_experiment(const Scenario& scenario) {
  const NoiseSource source(scenario.study.seed, noise_group(scenario));
  if (scenario.world.model == WorldModel::monobot) {
    return std::make_unique<LinearExperiment>(make_true_model(scenario), make_assumed_model(scenario),
                                              make_inflation_rule(scenario), scenario.study.steps, source);
  }
  PlanarWorld world = make_planar_world(scenario);
  if (scenario.filter.inflation == FilterInflation::none &&
      scenario.world.landmarks <= PlanarLanesExperiment::kMaxLandmarks) {
    const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
    return std::make_unique<PlanarLanesExperiment>(std::move(world), PlanarNoise::of(scenario), source,
                                                   assumed.Q, assumed.measurement_variance);
  }
  auto make_filter = [filter = make_planar_filter(scenario, world)] { return filter; };
  return std::make_unique<PlanarExperiment<EkfSlam<PlanarModel>>>(std::move(world), PlanarNoise::of(scenario),
                                                                  source, std::move(make_filter));
}

}  // namespace credence
