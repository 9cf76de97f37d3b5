#include <fmt/format.h>

#include <numbers>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/charted/charted_bound.h"
#include "montecarlo/worlds/charted/charted_settings.h"
#include "montecarlo/worlds/charted/charted_stream.h"
#include "montecarlo/worlds/localisation/localisation_model.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

std::vector<KeyRow> localisation_keys() {
  std::vector<KeyRow> keys = {
      planar_row("world", "path_radius"),
      planar_row("world", "speed"),
      planar_row("world", "dt"),
      {"world", "known_landmarks", "",
       "landmarks at known places, at equal angles on a circle half as large again as the path",
       own_integer("world.known_landmarks", 3, 1, 1000), aided_by_landmarks,
       "with world.model = \"localisation\" and world.aiding = \"landmarks\""},
      planar_row("noise", "speed_std"),
      planar_row("noise", "turn_rate_std"),
      planar_row("initial", "position_std"),
      planar_row("initial", "heading_std_deg"),
  };
  for (const KeyRow& row : charted_keys()) keys.push_back(row);
  return keys;
}

/// [Barrau 2017], as in the benchmark of [Brossard 2020]: a circle of 10 m across in 40 s.
void set_localisation_defaults(Scenario& scenario) {
  scenario.world.path_radius = 5.0;
  scenario.world.speed = std::numbers::pi / 4.0;
  scenario.world.dt = 0.01;
  scenario.noise.speed_std = 0.01;
  scenario.noise.turn_rate_std = kRadiansPerDegree;
  scenario.initial.position_std = 0.0;
  scenario.initial.heading_std_deg = 45.0;
  scenario.study.steps = 4000;
}

BlockLayout localisation_blocks(const Scenario&) { return {.vehicle = 3, .landmark = 0, .landmarks = 0}; }

std::string localisation_text(const Scenario& scenario) {
  return fmt::format("vehicle on a circle, its odometry noisy, {}", charted_text(scenario));
}

}  // namespace

constinit const World kLocalisationWorld = {
    .schema = {.name = "localisation",
               .meaning = "vehicle in the plane that knows its map, its error in any chart",
               .keys = localisation_keys,
               .set_defaults = set_localisation_defaults,
               .blocks = localisation_blocks},
    .experiment = charted_experiment<LocalisationModel>,
    .text = localisation_text,
    .figure = RunFigure::states,
    .posterior_bound = charted_bound<LocalisationModel>,
    .stream = charted_stream<LocalisationModel>};

}  // namespace credence::internal
