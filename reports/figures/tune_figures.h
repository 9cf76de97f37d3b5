#pragma once

#include <functional>
#include <string>

#include "analysis/tuning/tune_scenario.h"
#include "reports/figures/figure.h"

/// @file
/// The figures of `credence tune`.

namespace credence::internal {

/// From a parameter of the model to its name on an axis and the unit of that.
using KeyOfParameter = std::function<ScenarioScore::Key(const std::string& parameter)>;

/// The profile of every parameter that was found: how far the score falls with it held, with the level of the
/// likelihood-ratio interval, the tuned value and, where it is near, the present one.
Figure tune_profile_figure(const ScoreModel& model, const Tuning& tuning, const KeyOfParameter& key_of);

Figure tune_profile_figure(const ScenarioTuning& tuning);

/// The score over process and measurement noise, with the ridge on which the mean NIS is the expected one.
/// Precondition: tuning.ridge_of.
Figure tune_surface_figure(const ScenarioTuning& tuning);

}  // namespace credence::internal
