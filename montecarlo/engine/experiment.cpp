#include "montecarlo/engine/experiment.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/memory_need.h"
#include "montecarlo/engine/experiment_memory.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/filter_setup.h"
#include "montecarlo/worlds/monobot/intermittent_experiment.h"
#include "montecarlo/worlds/monobot/linear_experiment.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"

namespace credence {
namespace {

std::unique_ptr<Experiment> linear_experiment(const Scenario& scenario, const NoiseSource& source) {
  LinearModel truth = make_true_model(scenario);
  const LinearModel assumed = make_assumed_model(scenario);
  const InflationRule rule = make_inflation_rule(scenario);
  const double detected = scenario.noise.detection_probability;
  const Index steps = scenario.study.steps;
  if (detected < 1.0) {
    return std::make_unique<IntermittentExperiment>(
        IntermittentProblem{std::move(truth), assumed, rule, detected}, steps, source);
  }
  return std::make_unique<LinearExperiment>(std::move(truth), assumed, rule, steps, source);
}

/// The filter has a dense P over the landmarks that it sees at the start, and of more later.
void require_dense_covariance(const Scenario& scenario, const PlanarWorld& world) {
  const auto seen = std::ranges::count_if(
      world.landmarks.begin(), world.landmarks.begin() + world.states(),
      [&](const Point& landmark) { return world.sees(measure_range_bearing(world.start, landmark)); });
  const double n = 3.0 + 2.0 * scenario.noise.detection_probability * static_cast<double>(seen);
  require_memory(
      n * n * sizeof(double),
      fmt::format("world.landmarks = {}, of which {} are seen at the start", scenario.world.landmarks, seen));
}

template <PlanarSlamFilter F>
std::unique_ptr<Experiment> planar_experiment(F filter, PlanarWorld world, const Scenario& scenario,
                                              const NoiseSource& source) {
  auto make_filter = [filter = std::move(filter)] { return filter; };
  return std::make_unique<PlanarExperiment<F>>(std::move(world), PlanarNoise::of(scenario), source,
                                               std::move(make_filter));
}

}  // namespace

RunTrace Experiment::trace(std::int64_t run) const {
  RunTrace trace = describe_world();
  trace.layout = layout_;
  trace.run = run;
  trace.outcome = visit(run, [&](const TraceStep& step) { trace.steps.push_back(step); });
  return trace;
}

namespace {

std::unique_ptr<Experiment> experiment_of(const Scenario& scenario) {
  const NoiseSource source(scenario.study.seed, noise_group(scenario));
  if (scenario.world.model == WorldModel::monobot) return linear_experiment(scenario, source);
  PlanarWorld world = make_planar_world(scenario);
  if (!has_block_map(scenario)) require_dense_covariance(scenario, world);
  if (scenario.filter.inflation == FilterInflation::none &&
      scenario.world.landmarks <= PlanarLanesExperiment::kMaxLandmarks) {
    const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
    return std::make_unique<PlanarLanesExperiment>(std::move(world), PlanarNoise::of(scenario), source,
                                                   assumed.Q, assumed.measurement_variance);
  }
  if (has_block_map(scenario)) {
    BlockMapEkfSlam<PlanarModel> filter = make_block_map_filter(scenario, world);
    return planar_experiment(std::move(filter), std::move(world), scenario, source);
  }
  EkfSlam<PlanarModel> filter = make_planar_filter(scenario, world);
  return planar_experiment(std::move(filter), std::move(world), scenario, source);
}

/// Of one landmark's measurement, as the filter believes them to be.
std::vector<double> assumed_measurement_variances(const Scenario& scenario) {
  if (scenario.world.model == WorldModel::monobot) return {make_assumed_model(scenario).R(0, 0)};
  const RangeBearing variance = AssumedPlanarNoise::of(scenario).measurement_variance;
  return {variance[0], variance[1]};
}

}  // namespace

std::unique_ptr<Experiment> make_experiment(const Scenario& scenario) {
  require_experiment_memory(scenario);
  std::unique_ptr<Experiment> experiment = experiment_of(scenario);
  experiment->assume_measurement_variances(assumed_measurement_variances(scenario));
  return experiment;
}

}  // namespace credence
