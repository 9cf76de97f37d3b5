#include "montecarlo/worlds/planar/planar_registration.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/memory_need.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_bound.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"
#include "montecarlo/worlds/planar/planar_stream.h"
#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {
namespace {

void set_planar_defaults(Scenario& scenario) { scenario.world.dt = 0.25; }

void check_planar(const Scenario& scenario, const Refusal& refuse) {
  check_landmarks(scenario, refuse);
  const WorldSettings& world = scenario.world;
  if (world.sensor_min_range >= world.sensor_range) {
    refuse.impossible("world", "sensor_min_range",
                      fmt::format("must be < world.sensor_range = {}", world.sensor_range));
  }
  check_inflation(scenario, refuse);
}

BlockLayout planar_blocks(const Scenario& scenario) {
  return {.vehicle = 3, .landmark = 2, .landmarks = scenario.world.landmarks};
}

/// Places of landmarks, and a control a step.
double least_planar_doubles(const Scenario& scenario) {
  return 2.0 * static_cast<double>(scenario.world.landmarks + scenario.world.anchors + scenario.study.steps);
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
std::unique_ptr<Experiment> experiment_with(F filter, PlanarWorld world, const Scenario& scenario,
                                            const NoiseSource& source) {
  auto make_filter = [filter = std::move(filter)] { return filter; };
  return std::make_unique<PlanarExperiment<F>>(std::move(world), PlanarNoise::of(scenario), source,
                                               std::move(make_filter));
}

std::unique_ptr<Experiment> unlabelled_experiment(const Scenario& scenario) {
  const NoiseSource source = noise_source(scenario);
  PlanarWorld world = make_planar_world(scenario);
  if (!has_block_map(scenario)) require_dense_covariance(scenario, world);
  const bool inflate_map = scenario.filter.inflation == FilterInflation::map &&
                           scenario.filter.solution == InflationSolution::pairwise;
  if ((scenario.filter.inflation == FilterInflation::none || inflate_map) &&
      scenario.world.landmarks <= PlanarLanesExperiment::kMaxLandmarks) {
    const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
    return std::make_unique<PlanarLanesExperiment>(std::move(world), PlanarNoise::of(scenario), source,
                                                   assumed.Q, assumed.measurement_variance, inflate_map);
  }
  if (has_block_map(scenario)) {
    BlockMapEkfSlam<PlanarModel> filter = make_block_map_filter(scenario, world);
    return experiment_with(std::move(filter), std::move(world), scenario, source);
  }
  EkfSlam<PlanarModel> filter = make_planar_filter(scenario, world);
  return experiment_with(std::move(filter), std::move(world), scenario, source);
}

std::unique_ptr<Experiment> planar_experiment(const Scenario& scenario) {
  std::unique_ptr<Experiment> experiment = unlabelled_experiment(scenario);
  const RangeBearing variance = AssumedPlanarNoise::of(scenario).measurement_variance;
  experiment->assume_measurement_variances({variance[0], variance[1]});
  return experiment;
}

}  // namespace

constinit const World kPlanarWorld = {.schema = {.name = "planar",
                                                 .meaning = "vehicle in the plane with range and bearing",
                                                 .keys = planar_keys,
                                                 .set_defaults = set_planar_defaults,
                                                 .check = check_planar,
                                                 .blocks = planar_blocks},
                                      .linear_problem = nullptr,
                                      .experiment = planar_experiment,
                                      .least_doubles = least_planar_doubles,
                                      .size_text = slam_size_text,
                                      .text = slam_text,
                                      .figure = RunFigure::plane_slam,
                                      .posterior_bound = planar_bound,
                                      .stream = planar_stream};

}  // namespace credence::internal
