#pragma once

#include <span>
#include <string>
#include <string_view>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {

/// Values that are accepted each, and exclude each other.
struct ImpossibleCombination : ScenarioError {
  using ScenarioError::ScenarioError;
};

/// The scenario that `settings` (each key at most once) describe, everything else at its default.
///
/// `origin` names their source where a required key is missing. Throws ScenarioError for unknown keys, wrong
/// types, values out of range and keys that do not belong to the chosen model; ImpossibleCombination else.
Scenario resolve_scenario(std::span<const Setting> settings, const std::string& origin);

/// Throws the ScenarioError of a setting that names no key: a suggestion, and the keys there are.
/// `settings` tell the model, whose keys are listed.
[[noreturn]] void throw_unknown_key(const Setting& setting, std::span<const Setting> settings);

/// The keys that a name without its section may mean, as "world.Q or filter.Q": those of that name, or else
/// of the name nearest to it; empty: there are none.
std::string keys_without_section(std::string_view name);

}  // namespace credence::internal
