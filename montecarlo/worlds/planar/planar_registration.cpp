#include <fmt/format.h>

#include <algorithm>

#include "core/memory_need.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_bound.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/world_list.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {
namespace {

void set_planar_defaults(Scenario& scenario) { scenario.world.dt = 0.25; }

void check_planar(const Scenario& scenario, const Refusal& refuse) {
  check_landmarks(scenario, refuse);
  check_sensor_range(scenario, refuse);
  check_inflation(scenario, refuse);
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

/// Nominal controls, and range (m) and bearing (rad) of the landmarks in view.
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

}  // namespace

constinit const World kPlanarWorld = {.schema = {.name = "planar",
                                                 .meaning = "vehicle in the plane with range and bearing",
                                                 .keys = planar_keys,
                                                 .set_defaults = set_planar_defaults,
                                                 .check = check_planar,
                                                 .blocks = plane_slam_blocks},
                                      .experiment = planar_experiment,
                                      .least_doubles = least_planar_doubles,
                                      .size_text = slam_size_text,
                                      .text = slam_text,
                                      .figure = RunFigure::plane_slam,
                                      .posterior_bound = planar_bound,
                                      .stream = planar_stream};

}  // namespace credence::internal
