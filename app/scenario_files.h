#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/sweep_plan.h"

/// @file
/// What a user of the program or of the Python module names as a scenario: a file, or one that comes with
/// them, by its name alone.

namespace credence::internal {

/// A scenario that comes with the program.
struct OwnScenario {
  std::string_view name;  ///< "planar_loop"
  std::string title;      ///< the first sentence of its first comment
  std::string_view text;  ///< TOML
  bool sweep = false;     ///< has a [sweep] table
};

/// All of them, in the order of their names.
std::vector<OwnScenario> own_scenarios();

bool is_own_scenario(std::string_view name);

/// The document of a file or, where there is none, of the program's scenario of that name.
///
/// Throws ScenarioError as read_scenario does; where there is neither, with a proposal.
ScenarioDocument open_scenario(const std::string& name, std::span<const std::string> overrides = {});

/// Its one configuration, leaving a [sweep] table aside.
Scenario open_one_scenario(const std::string& name, std::span<const std::string> overrides = {});

/// What the author says of the scenario: its leading comment. Throws as open_scenario.
std::string scenario_comment(const std::string& name);

/// All of its configurations.
SweepPlan open_sweep(const std::string& name, std::span<const std::string> overrides = {});

/// Where a sweep is stored that nobody named a folder for. Every plan has one of its own, so that one that is
/// changed begins anew.
std::filesystem::path default_directory(const SweepPlan& plan);

}  // namespace credence::internal
