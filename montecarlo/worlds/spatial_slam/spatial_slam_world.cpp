#include <fmt/format.h>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/estimator_key.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/plugged/plugged_statistics.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/spatial_slam/spatial_bound.h"
#include "montecarlo/worlds/spatial_slam/spatial_run.h"
#include "montecarlo/worlds/world_list.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {
namespace {

RunLayout layout_of(const SpatialWorld& world, const SpatialKind& kind) {
  RunLayout layout = spatial_layout(world);
  layout.componentwise = kind.chart == SpatialChart::componentwise;
  return layout;
}

/// Many runs of one estimator, judged by its pose in its chart; `credence estimators` judges the map.
class SpatialExperiment final : public VisitedExperiment {
 public:
  SpatialExperiment(const SpatialWorld& world, const SpatialKind& kind, const NoiseSource& source)
      : VisitedExperiment(layout_of(world, kind), world.steps()),
        world_(world),
        kind_(kind),
        source_(source) {}

  Outcome visit(std::int64_t number, const StepVisitor& take) const override {
    SpatialSimulation simulation(world_, source_);
    SpatialRun run(world_, kind_);
    run.start(simulation.start(number));
    std::size_t now = 0;
    return visit_steps(
        world_.steps(), take,
        [&](Index k) {
          now = static_cast<std::size_t>(k);
          return run.step(now, simulation.read(now), simulation.observe(now));
        },
        [&] { return show(run.filter(), world_.path[now]); });
  }

  RunTrace describe_world() const override { return {}; }

 private:
  static TraceStep show(const SpatialSlam& filter, const SE3& truth) {
    TraceStep step;
    step.states = {0, 1, 2, 3, 4, 5};
    step.truth = truth.split().Log();
    step.error = -filter.pose_error(truth, true);
    step.estimate = step.truth + step.error;
    step.P = filter.own_pose_covariance();
    step.innovations.front() = {filter.innovation(), filter.innovation_covariance()};
    normalise_step(step);
    return step;
  }

  SpatialWorld world_;
  SpatialKind kind_;
  NoiseSource source_;
};

std::vector<KeyRow> spatial_slam_keys() {
  const auto metres = [](std::string_view name, std::string_view meaning, double value) {
    return KeyRow{"world", name, "m", meaning,
                  own_real(fmt::format("world.{}", name), value, Interval::kPositive)};
  };
  const auto share = [](std::string_view name, std::string_view meaning) {
    return KeyRow{"noise", name, "", meaning,
                  own_real(fmt::format("noise.{}", name), 0.01, Interval::kPositive)};
  };
  return {
      planar_row("world", "landmarks"),
      metres("path_length", "length of the elliptic path, seen from above", 50.0),
      metres("path_width", "its width", 40.0),
      metres("path_height", "between its highest and lowest places, each taken twice a loop", 20.0),
      {"world", "loop_steps", "", "steps of one loop",
       own_real("world.loop_steps", 62.5, Interval::kPositive)},
      metres("landmark_spread", "landmarks lie evenly in balls of this radius about the path", 20.0),
      {"world", "map", "", "number of the map that is drawn; the same whatever the seed",
       own_integer("world.map", 1, 1, 1'000'000'000)},
      planar_row("world", "sensor_min_range"),
      planar_row("world", "sensor_range"),
      planar_row("world", "field_of_view_deg"),
      share("odometry_share",
            "standard deviation of each coordinate of a step and of a turn that is read, "
            "over what noise.share_of says"),
      share("landmark_share",
            "standard deviation of each coordinate of a landmark's place in the frame of "
            "the vehicle, over what noise.share_of says"),
      {"noise", "share_of", "", "length: that of the step, turn or place; coordinate: each by itself",
       own_choice("noise.share_of", {"length", "coordinate"})},
      planar_row("initial", "position_std"),
      planar_row("initial", "heading_std_deg"),
      estimator_key(),
      process_scale_key(),
      measurement_scale_key(),
  };
}

void set_spatial_slam_defaults(Scenario& scenario) {
  scenario.world.landmarks = 300;
  scenario.world.sensor_range = 20.0;
  scenario.world.field_of_view_deg = 120.0;
  scenario.study.steps = 500;
}

void check_spatial_slam(const Scenario& scenario, const Refusal& refuse) {
  check_contested_slam(scenario, refuse, kSpatialOffer);
}

BlockLayout spatial_slam_blocks(const Scenario&) { return {.vehicle = 6, .landmark = 0, .landmarks = 0}; }

double least_spatial_slam_doubles(const Scenario& scenario) {
  const double n = 6.0 + 3.0 * static_cast<double>(scenario.world.landmarks);
  return n * n + 26.0 * static_cast<double>(scenario.study.steps);
}

std::string spatial_slam_text(const Scenario& scenario) {
  return fmt::format(
      "vehicle on a closed path in space, its odometry noisy, {} landmarks, relative position{}{}",
      scenario.world.landmarks, detection_text(scenario), noise_switches_text(scenario));
}

std::unique_ptr<Experiment> spatial_slam_experiment(const Scenario& scenario) {
  return std::make_unique<SpatialExperiment>(make_spatial_world(scenario),
                                             spatial_kind(word_value(scenario, "filter.estimator")),
                                             noise_source(scenario));
}

PosteriorBound spatial_slam_bound(const Scenario& scenario) {
  if (spatial_kind(word_value(scenario, "filter.estimator")).chart != SpatialChart::componentwise) {
    return {.reason = kBoundOfDifferences};
  }
  return spatial_bound(make_spatial_world(scenario));
}

Vector pose_coordinates(const SE3& pose) { return pose.split().Log(); }

Vector odometry_numbers(const SpatialControl& read) {
  Vector numbers(6);
  numbers << read.v, read.omega;
  return numbers;
}

/// Odometry read with noise, v (m) and ω (rad) of a step, and the places (m) of the landmarks in view in the
/// frame of the vehicle. Of the noise the scenario tells the shares, by what is read.
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

}  // namespace

constinit const World kSpatialSlamWorld = {
    .schema = {.name = "spatial_slam",
               .meaning = "vehicle on a path in space that maps landmarks, any of several estimators",
               .keys = spatial_slam_keys,
               .set_defaults = set_spatial_slam_defaults,
               .check = check_spatial_slam,
               .blocks = spatial_slam_blocks},
    .experiment = spatial_slam_experiment,
    .least_doubles = least_spatial_slam_doubles,
    .size_text = landmarks_size_text,
    .text = spatial_slam_text,
    .figure = RunFigure::states,
    .estimators = &kSpatialOffer,
    .posterior_bound = spatial_slam_bound,
    .stream = spatial_stream};

}  // namespace credence::internal
