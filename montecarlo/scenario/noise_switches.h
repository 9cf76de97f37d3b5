#pragma once

#include <string>
#include <vector>

#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

/// @file
/// The switches that make the noise of any world other than its filter believes: what is missed, outliers,
/// tails, correlation, delay.

namespace credence::internal {

/// Their rows of [noise], which every world has.
std::vector<KeyRow> noise_switch_keys();

/// Refuses a switch that cannot be set so.
void check_noise_switches(const Scenario& scenario, const Refusal& refuse);

/// The source of all noise of a scenario, shaped by its switches.
NoiseSource noise_source(const Scenario& scenario);

/// Steps after which a measurement reaches the filter, which takes it for one of that step.
Index measurement_delay(const Scenario& scenario);

/// " with probability 0.6" where a measurement may be missed, else nothing.
std::string detection_text(const Scenario& scenario);

/// ", outliers at rate 0.05, delayed by 1 step": the switches that are on but for detection_probability, in a
/// few words.
std::string noise_switches_text(const Scenario& scenario);

}  // namespace credence::internal
