#include <fmt/format.h>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/charted/charted_bound.h"
#include "montecarlo/worlds/charted/charted_settings.h"
#include "montecarlo/worlds/charted/charted_stream.h"
#include "montecarlo/worlds/inertial/inertial_model.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

/// The MTi-G-700 of [Xsens 2018]: 0.01 °/s/√Hz and 60 µg/√Hz. Of the walks the manual says nothing; they and
/// the bias of the accelerometer at the start are assumed.
constexpr double kGyroDensity = 0.01 * kRadiansPerDegree, kAccelerometerDensity = 60e-6 * 9.80665;

bool cones(const Scenario& s) { return real_value(s, "world.coning_angle_deg") > 0.0; }
bool sculls(const Scenario& s) { return cones(s) && real_value(s, "world.sculling_acceleration") > 0.0; }

std::vector<KeyRow> inertial_keys() {
  std::vector<KeyRow> keys = {
      planar_row("world", "path_radius"),
      planar_row("world", "speed"),
      planar_row("world", "dt"),
      {"world", "attitude", "", "along_path: the vehicle turns as its path does; fixed: it does not turn",
       own_choice("world.attitude", {"along_path", "fixed"})},
      {.section = "world",
       .name = "coning_angle_deg",
       .unit = "deg",
       .meaning = "half-angle of a cone on which the axis of the unit moves",
       .field = own_real("world.coning_angle_deg", 0.0, Interval::kNotNegative),
       .in_effect = cones},
      {.section = "world",
       .name = "coning_frequency",
       .unit = "Hz",
       .meaning = "how often it goes round; of no effect with coning_angle_deg = 0",
       .field = own_real("world.coning_frequency", 10.0, Interval::kPositive),
       .in_effect = cones},
      {.section = "world",
       .name = "sculling_acceleration",
       .unit = "m/s^2",
       .meaning =
           "amplitude of a vertical shaking of the coning unit, in phase with its tilt about the first "
           "axis; of no effect with coning_angle_deg = 0",
       .field = own_real("world.sculling_acceleration", 0.0, Interval::kNotNegative),
       .in_effect = sculls},
      own_row("noise", "gyro_density", "rad/s/√Hz", "density of the white noise of each rate gyro",
              kGyroDensity),
      own_row("noise", "accelerometer_density", "m/s²/√Hz",
              "density of the white noise of each accelerometer", kAccelerometerDensity),
      own_row("noise", "gyro_bias_walk", "rad/s²/√Hz", "density of the random walk of a gyro's bias", 1e-5),
      own_row("noise", "accelerometer_bias_walk", "m/s³/√Hz",
              "density of the random walk of an accelerometer's bias", 1e-4),
      {"noise", "velocity_std", "m/s", "standard deviation of each coordinate of a velocity by satellites",
       own_real("noise.velocity_std", 0.1, Interval::kPositive), aided_by_satellites,
       "with world.model = \"inertial\" and world.aiding = \"satellites\""},
      planar_row("initial", "position_std"),
      own_row("initial", "velocity_std", "m/s",
              "standard deviation of each coordinate of the velocity at the start", 1.0),
      own_row("initial", "attitude_std_deg", "deg",
              "standard deviation of the attitude at the start, about each axis", 5.0),
      own_row("initial", "gyro_bias_std", "rad/s", "standard deviation of a gyro's bias at the start",
              0.5 * kRadiansPerDegree),
      own_row("initial", "accelerometer_bias_std", "m/s^2",
              "standard deviation of an accelerometer's bias at the start", 0.05),
  };
  for (const KeyRow& row : charted_keys()) keys.push_back(row);
  return keys;
}

void set_inertial_defaults(Scenario& scenario) {
  scenario.world.path_radius = 50.0;
  scenario.world.speed = 10.0;
  scenario.world.dt = 0.01;
  scenario.initial.position_std = 1.0;
  scenario.study.steps = 3000;
}

BlockLayout inertial_blocks(const Scenario&) {
  return {.vehicle = InertialModel::Group::kDim, .landmark = 0, .landmarks = 0};
}

std::string inertial_text(const Scenario& scenario) {
  return fmt::format("strapdown inertial unit on a circle{}, {}",
                     sculls(scenario)  ? ", coning and sculling"
                     : cones(scenario) ? ", coning"
                                       : "",
                     charted_text(scenario));
}

}  // namespace

constinit const World kInertialWorld = {
    .schema = {.name = "inertial",
               .meaning = "strapdown inertial unit with biases, its error in any chart",
               .keys = inertial_keys,
               .set_defaults = set_inertial_defaults,
               .blocks = inertial_blocks},
    .experiment = charted_experiment<InertialModel>,
    .text = inertial_text,
    .figure = RunFigure::states,
    .posterior_bound = charted_bound<InertialModel>,
    .stream = charted_stream<InertialModel>};

}  // namespace credence::internal
