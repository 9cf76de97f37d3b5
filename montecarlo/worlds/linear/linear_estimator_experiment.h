#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// kalman, steady-state, schmidt, own-gain and smoother, as far as `scenario` says what they need; null: all.
std::vector<std::string_view> linear_estimator_names(const Scenario* scenario);

/// The experiment of one of them, whatever filter.estimator says. Throws std::invalid_argument for what the
/// scenario does not say, a gain that does not settle, or missed measurements with any but kalman.
std::unique_ptr<Experiment> linear_estimator_experiment(const Scenario& scenario, std::string_view name);

}  // namespace credence::internal
