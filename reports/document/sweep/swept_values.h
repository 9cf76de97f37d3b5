#pragma once

#include <string>

#include "montecarlo/scenario/sweep_plan.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// A swept value as a person reads it: a word without its quotes.
std::string swept_text(const ScalarValue& value);

/// The number of a swept value, NaN for a word.
double swept_number(const ScalarValue& value);

/// Keys and values of one point of a sweep: {"world.landmarks": 3, …}.
Json swept_json(const SweepPlan& plan, const SweepPoint& point);

}  // namespace credence::internal
