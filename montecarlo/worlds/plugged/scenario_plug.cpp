#include "montecarlo/worlds/plugged/scenario_plug.h"

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {

PlugSettings plug_settings(const Scenario& scenario) {
  const NoiseSource source = noise_source(scenario);
  return {.steps = scenario.study.steps,
          .seed = scenario.study.seed,
          .noise_group = noise_group(scenario),
          .process_shape = source.process_shape(),
          .measurement_shape = source.measurement_shape(),
          .measurement_delay = measurement_delay(scenario)};
}

}  // namespace credence::internal
