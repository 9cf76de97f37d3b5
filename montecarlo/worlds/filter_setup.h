#pragma once

#include "core/inflation/inflation_rule.h"
#include "core/models/linear_model.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// From the settings of a scenario to what the core computes with.

namespace credence {

/// The inflation that [filter] asks for; of `rank`, the constant ΔP for the complete map.
InflationRule make_inflation_rule(const Scenario& scenario);

/// The monobot as it is.
LinearModel make_true_model(const Scenario& scenario);

/// The monobot as its filter believes it to be: noise scaled by process_scale and measurement_scale.
LinearModel make_assumed_model(const Scenario& scenario);

}  // namespace credence
