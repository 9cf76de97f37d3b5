#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {

/// A scenario file and its overrides as read, before anything is known of models and defaults.
struct ScenarioDocument {
  std::string file;               ///< as the user named it, for messages
  std::string name;               ///< stem of the file
  std::vector<Setting> settings;  ///< one for each key given, in the order of the file
  std::vector<Setting> sweep;     ///< of the [sweep] table: section.key of what is swept, or .mode and such
};

/// Reads a TOML file and applies `overrides`, each `section.key=value`, over it; the last of a key wins.
///
/// The value of an override is a TOML value; what is none is taken as a string, so words need no quotes.
/// `sweep.section.key=list` overrides the [sweep] table. Throws ScenarioError for a file that is missing,
/// unreadable, larger than 1 MiB or broken TOML, for duplicate keys, and for a malformed override.
ScenarioDocument read_scenario(const std::filesystem::path& file,
                               std::span<const std::string> overrides = {});

/// The same from TOML text; `file` stands for it in messages.
ScenarioDocument read_scenario_text(std::string_view text, const std::string& file,
                                    std::span<const std::string> overrides = {});

}  // namespace credence::internal

namespace credence {

/// The one configuration of a scenario file, leaving its [sweep] table aside. `overrides` are
/// `section.key=value`, the last of a key wins.
///
/// Throws ScenarioError for a file that is missing, unreadable, larger than 1 MiB or broken TOML, for unknown
/// and duplicate keys, wrong types and impossible values.
Scenario load_scenario(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from TOML text; `file` stands for it in messages.
Scenario load_scenario_text(std::string_view text, const std::string& file,
                            std::span<const std::string> overrides = {});

}  // namespace credence
