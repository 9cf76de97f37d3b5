#include "montecarlo/worlds/tracking/tracking_world.h"

#include <fmt/format.h>

#include <utility>

#include "core/append_item.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_world.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/tracking/range_bearing_tracking.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

constexpr std::string_view kOnlyPosition = "with world.model = \"tracking\" and world.sensor = \"position\"";
constexpr std::string_view kOnlyRangeBearing =
    "with world.model = \"tracking\" and world.sensor = \"range_bearing\"";

bool measures_position(const Scenario& s) { return word_value(s, "world.sensor") == "position"; }
bool measures_range(const Scenario& s) { return !measures_position(s); }

std::vector<KeyRow> tracking_keys() {
  return {
      {"world", "dimensions", "", "of the space in which the target moves",
       own_integer("world.dimensions", 2, 1, 3)},
      {"world", "sensor", "",
       "what is measured: each coordinate of the target, or range and bearing from the origin of the plane",
       own_choice("world.sensor", {"position", "range_bearing"})},
      {"world", "target_range", "m", "distance of the target abeam of the sensor at the start",
       own_real("world.target_range", 100.0, Interval::kPositive)},
      planar_row("world", "speed"),
      planar_row("world", "dt"),
      {"noise", "acceleration_density", "m^2/s^3",
       "power spectral density of the target's white noise acceleration, of each coordinate",
       own_real("noise.acceleration_density", 0.1, Interval::kNotNegative)},
      {"noise", "position_std", "m", "standard deviation of a measured coordinate",
       own_real("noise.position_std", 1.0, Interval::kNotNegative), measures_position, kOnlyPosition},
      planar_row("noise", "range_std", measures_range, kOnlyRangeBearing),
      planar_row("noise", "bearing_std_deg", measures_range, kOnlyRangeBearing),
      planar_row("initial", "position_std"),
      {"initial", "velocity_std", "m/s", "standard deviation of each coordinate of the velocity at the start",
       own_real("initial.velocity_std", 1.0, Interval::kNotNegative)},
      process_scale_key(),
      measurement_scale_key(),
  };
}

void set_tracking_defaults(Scenario& scenario) { scenario.initial.position_std = 10.0; }

Index dimensions(const Scenario& scenario) { return integer_value(scenario, "world.dimensions"); }

void check_tracking(const Scenario& scenario, const Refusal& refuse) {
  if (measures_range(scenario) && dimensions(scenario) != 2) {
    refuse.impossible("world", "dimensions", "must be 2 with world.sensor = \"range_bearing\"");
  }
}

BlockLayout tracking_blocks(const Scenario& scenario) {
  return {.vehicle = 2 * dimensions(scenario), .landmark = 0, .landmarks = 0};
}

std::optional<LinearProblem> tracking_problem_of(const Scenario& scenario) {
  if (measures_range(scenario)) return std::nullopt;
  LinearProblem problem;
  problem.truth = target_model(scenario);
  problem.assumed = problem.truth;
  problem.assumed.Q *= scenario.filter.process_scale;
  problem.assumed.R *= scenario.filter.measurement_scale;
  problem.detection_probability = scenario.noise.detection_probability;
  problem.measurement_delay = measurement_delay(scenario);
  problem.scene = {.layout = target_layout(scenario, problem.assumed.R),
                   .start = target_start(scenario),
                   .random_start = true};
  return problem;
}

std::unique_ptr<Experiment> tracking_experiment(const Scenario& scenario) {
  return std::make_unique<RangeBearingTracking>(scenario, noise_source(scenario));
}

double least_tracking_doubles(const Scenario& scenario) {
  const double d = static_cast<double>(dimensions(scenario));
  return measures_position(scenario) ? linear_problem_doubles(2.0 * d, d, scenario) : 0.0;
}

std::string tracking_size_text(const Scenario& scenario) {
  return fmt::format("world.dimensions = {}", dimensions(scenario));
}

std::string tracking_text(const Scenario& scenario) {
  const Index d = dimensions(scenario);
  return fmt::format("target of nearly constant velocity in {}, {} measured{}{}", counted(d, "dimension"),
                     measures_position(scenario) ? "position" : "range and bearing", detection_text(scenario),
                     noise_switches_text(scenario));
}

}  // namespace

LinearModel target_model(const Scenario& scenario) {
  const Index d = dimensions(scenario);
  const double T = scenario.world.dt, q = real_value(scenario, "noise.acceleration_density");
  const Matrix I = Matrix::Identity(d, d), zero = Matrix::Zero(d, d);
  LinearModel model;
  model.F = Matrix(2 * d, 2 * d);
  model.F << I, T * I, zero, I;
  model.G = Matrix::Identity(2 * d, 2 * d);
  model.Q = Matrix(2 * d, 2 * d);
  model.Q << T * T * T / 3.0 * I, T * T / 2.0 * I, T * T / 2.0 * I, T * I;
  model.Q *= q;
  model.H = Matrix(d, 2 * d);
  model.H << I, zero;
  const double measured = real_value(scenario, "noise.position_std");
  model.R = measured * measured * I;
  const double position = scenario.initial.position_std;
  const double velocity = real_value(scenario, "initial.velocity_std");
  model.P0 = Matrix::Zero(2 * d, 2 * d);
  model.P0.diagonal() << Vector::Constant(d, position * position), Vector::Constant(d, velocity * velocity);
  model.layout = tracking_blocks(scenario);
  return model;
}

Vector target_start(const Scenario& scenario) {
  const Index d = dimensions(scenario);
  Vector x = Vector::Zero(2 * d);
  x[d == 1 ? 0 : 1] = real_value(scenario, "world.target_range");
  x[d] = scenario.world.speed;
  return x;
}

RunLayout target_layout(const Scenario& scenario, const Matrix& R) {
  std::vector<std::string> states, units;
  for (const auto& [block, unit] : {std::pair("position", "m"), std::pair("velocity", "m/s")}) {
    for (Index axis = 0; axis < dimensions(scenario); ++axis) {
      states.push_back(fmt::format("{}.{}", block, "xyz"[axis]));
      units.emplace_back(unit);
    }
  }
  RunLayout layout = linear_layout(std::move(states), R, scenario.noise.detection_probability == 1.0);
  layout.units = std::move(units);
  layout.blocks.front().part = Part::position;
  return layout;
}

constinit const World kTrackingWorld = {.schema = {.name = "tracking",
                                                   .meaning = "target of nearly constant velocity",
                                                   .keys = tracking_keys,
                                                   .set_defaults = set_tracking_defaults,
                                                   .check = check_tracking,
                                                   .blocks = tracking_blocks},
                                        .linear_problem = tracking_problem_of,
                                        .experiment = tracking_experiment,
                                        .least_doubles = least_tracking_doubles,
                                        .size_text = tracking_size_text,
                                        .text = tracking_text,
                                        .figure = RunFigure::states,
                                        .posterior_bound = range_bearing_bound};

}  // namespace credence::internal
