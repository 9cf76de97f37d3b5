#pragma once

#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/estimator_contest.h"

namespace credence::internal {

/// filter.estimator, the same key in every world that has estimators: its words are those of all of them.
/// Of no effect where `in_effect` says so.
KeyRow estimator_key(bool (*in_effect)(const Scenario&) = nullptr);

/// Makes an estimator the default of a world.
void set_estimator(Scenario& scenario, std::string_view name);

/// Refuses an estimator of another world.
void check_estimator(const Scenario& scenario, const Refusal& refuse, const EstimatorOffer& offer);

}  // namespace credence::internal
