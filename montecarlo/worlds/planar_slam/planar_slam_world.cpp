#include <fmt/format.h>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/estimator_key.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/planar_slam/odometry_bound.h"
#include "montecarlo/worlds/planar_slam/planar_slam_experiment.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/world_list.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {
namespace {

bool has_annulus(const Scenario& s) { return !has_landmark_ring(s); }
bool measures_bearing(const Scenario& s) { return !measures_relative_position(s); }
bool has_sigma_points(const Scenario& s) { return word_value(s, "filter.estimator").starts_with("ukf"); }
bool has_window(const Scenario& s) { return word_value(s, "filter.estimator").starts_with("smoother"); }
bool considers(const Scenario& s) { return word_value(s, "filter.estimator") == "schmidt"; }

std::vector<KeyRow> planar_slam_keys() {
  constexpr std::string_view kRing =
      "with world.model = \"planar_slam\" and world.landmark_layout = \"ring\"";
  constexpr std::string_view kAnnulus =
      "with world.model = \"planar_slam\" and world.landmark_layout = \"annulus\"";
  constexpr std::string_view kPosition =
      "with world.model = \"planar_slam\" and world.landmark_sensor = \"relative_position\"";
  constexpr std::string_view kRange =
      "with world.model = \"planar_slam\" and world.landmark_sensor = \"range_bearing\"";
  std::vector<KeyRow> keys;
  for (const char* name :
       {"landmarks", "path_radius", "speed", "dt", "sensor_min_range", "sensor_range", "field_of_view_deg"}) {
    keys.push_back(planar_row("world", name));
  }
  keys.insert(
      keys.end(),
      {{"world", "landmark_layout", "",
        "ring: at equal angles on a circle about the path's centre; annulus: drawn evenly over an annulus "
        "around the path",
        own_choice("world.landmark_layout", {"ring", "annulus"})},
       {"world", "ring_offset", "m", "radius of the ring of landmarks beyond that of the path",
        own_real("world.ring_offset", 3.0, Interval::kNotNegative), has_landmark_ring, kRing},
       {"world", "annulus_half_width", "m", "landmarks lie so far inside and outside the path at most",
        own_real("world.annulus_half_width", 5.0, Interval::kPositive), has_annulus, kAnnulus},
       {"world", "map", "", "number of the map that is drawn; the same whatever the seed",
        own_integer("world.map", 1, 1, 1'000'000'000), has_annulus, kAnnulus},
       {"world", "landmark_sensor", "",
        "what is measured of a landmark: its place in the frame of the vehicle, or range and bearing",
        own_choice("world.landmark_sensor", {"relative_position", "range_bearing"})},
       planar_row("noise", "speed_std"),
       planar_row("noise", "turn_rate_std"),
       {"noise", "relative_position_std", "m", "standard deviation of each coordinate of a relative position",
        own_real("noise.relative_position_std", 0.1, Interval::kPositive), measures_relative_position,
        kPosition},
       planar_row("noise", "range_std", measures_bearing, kRange),
       planar_row("noise", "bearing_std_deg", measures_bearing, kRange),
       planar_row("initial", "position_std"),
       planar_row("initial", "heading_std_deg"),
       estimator_key(),
       {.section = "filter",
        .name = "sigma_spread",
        .unit = "",
        .meaning = "α of the sigma points of \"ukf\" and \"ukf-manifold\", of no effect elsewhere",
        .field = own_real("filter.sigma_spread", 1e-3, {0.0, 1.0, true, false}),
        .in_effect = has_sigma_points},
       {.section = "filter",
        .name = "window",
        .unit = "",
        .meaning = "times of observations that \"smoother\" keeps, of no effect elsewhere",
        .field = own_integer("filter.window", 10, 1, 1000),
        .in_effect = has_window},
       {.section = "filter",
        .name = "active_sights",
        .unit = "",
        .meaning = "observations after which \"schmidt\" only considers a landmark, of no effect elsewhere",
        .field = own_integer("filter.active_sights", 30, 0, 1'000'000'000),
        .in_effect = considers},
       process_scale_key(),
       measurement_scale_key()});
  return keys;
}

void set_planar_slam_defaults(Scenario& scenario) {
  scenario.world.landmarks = 20;
  scenario.world.speed = 0.25;
  scenario.world.sensor_range = 5.0;
  scenario.noise.speed_std = 0.01;
  scenario.noise.turn_rate_std = 0.03;
}

void check_planar_slam(const Scenario& scenario, const Refusal& refuse) {
  check_contested_slam(scenario, refuse, kPlanarSlamOffer);
}

/// A dense P, and a pose and a control a step.
double least_planar_slam_doubles(const Scenario& scenario) {
  const double n = 3.0 + 2.0 * static_cast<double>(scenario.world.landmarks);
  return n * n + 5.0 * static_cast<double>(scenario.study.steps);
}

std::string planar_slam_text(const Scenario& scenario) {
  return fmt::format("vehicle on a circle, its odometry noisy, {} landmarks {}, {} measured{}{}",
                     scenario.world.landmarks, has_landmark_ring(scenario) ? "on a ring" : "in an annulus",
                     measures_relative_position(scenario) ? "relative position" : "range and bearing",
                     detection_text(scenario), noise_switches_text(scenario));
}

std::unique_ptr<Experiment> planar_slam_experiment(const Scenario& scenario) {
  return std::make_unique<PlanarSlamExperiment>(scenario, noise_source(scenario));
}

PosteriorBound planar_slam_bound(const Scenario& scenario) {
  const OdometryWorld world = make_odometry_world(scenario);
  if (scenario_estimator(scenario, world)->chart() != ErrorChart::plane) {
    return {.reason = kBoundOfDifferences};
  }
  return odometry_bound(world);
}

/// Odometry read with noise, and what the sensor says of the landmarks in view: their relative positions (m),
/// or range (m) and bearing (rad).
WorldStream odometry_stream(const Scenario& scenario) {
  const OdometryWorld world = make_odometry_world(scenario);
  const auto play = [world, source = noise_source(scenario)](std::int64_t run, const RowVisitor& take) {
    OdometrySimulation simulation(world, source);
    take(0, {.prior = simulation.start(run), .truth = world.path.front()});
    for (std::size_t k = 1; k < world.path.size(); ++k) {
      take(static_cast<std::int64_t>(k),
           {.truth = world.path[k],
            .input = simulation.read(k),
            .measurement = numbers_of_observations(simulation.observe(k), world.plane.landmarks.size())});
    }
  };
  const bool relative = world.sensor.kind != LandmarkSensorKind::range_bearing;
  return {.states = {"vehicle.x", "vehicle.y", "vehicle.heading"},
          .inputs = {"1", "2"},
          .measurements = names_of_landmarks(
              world.plane.landmarks.size(),
              relative ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"range", "bearing"}),
          .notes = text_of_landmarks(world.plane.landmarks),
          .visit = play};
}

}  // namespace

constinit const World kPlanarSlamWorld = {
    .schema = {.name = "planar_slam",
               .meaning = "vehicle on a circle, any of several estimators",
               .keys = planar_slam_keys,
               .set_defaults = set_planar_slam_defaults,
               .check = check_planar_slam,
               .blocks = plane_slam_blocks},
    .experiment = planar_slam_experiment,
    .least_doubles = least_planar_slam_doubles,
    .size_text = landmarks_size_text,
    .text = planar_slam_text,
    .figure = RunFigure::plane_slam,
    .estimators = &kPlanarSlamOffer,
    .posterior_bound = planar_slam_bound,
    .stream = odometry_stream};

}  // namespace credence::internal
