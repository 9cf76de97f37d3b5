#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_value.h"

/// @file
/// The one table of all keys of a scenario. Reading, checking, the canonical text, the help text and the
/// reference page come from it; a new key is a new row.

namespace credence {

/// The finite numbers between two bounds.
struct Interval {
  double low, high;
  bool low_open, high_open;  ///< whether the bound itself is excluded
};

struct RealField {
  double (*get)(const Scenario&);
  void (*set)(Scenario&, double);
  Interval accepted;
};
struct IntegerField {
  std::int64_t (*get)(const Scenario&);
  void (*set)(Scenario&, std::int64_t);
  std::int64_t low, high;
};
struct ChoiceField {
  std::size_t (*get)(const Scenario&);
  void (*set)(Scenario&, std::size_t);
  std::vector<std::string_view> words;  ///< in the order of the enum
};

/// One row of the table.
struct ScenarioKey {
  std::string_view section;
  std::string_view name;
  std::string_view unit;     ///< empty for a pure number or word
  std::string_view meaning;  ///< one sentence
  std::variant<RealField, IntegerField, ChoiceField> field;
  bool (*accepted)(const Scenario&);   ///< whether the key may be given in such a scenario
  std::string_view accepted_when;      ///< the same in words; empty: always
  bool (*in_effect)(const Scenario&);  ///< whether the key plays a part; else it rests at its default

  std::string path() const;  ///< section.name
};

/// All keys, in canonical order.
std::span<const ScenarioKey> scenario_keys();

/// The sections, in canonical order.
std::vector<std::string_view> scenario_sections();

/// The key `section.name`, or nullptr.
const ScenarioKey* find_scenario_key(std::string_view section, std::string_view name);

/// What a key accepts in words: `a finite number >= 0`, `one of "none", "full", "map", "rank"`.
std::string accepted_values(const ScenarioKey& key);

/// The value of a key in a resolved scenario, as a scalar (words as strings).
ScalarValue key_value(const ScenarioKey& key, const Scenario& scenario);

/// Sets a key from a value as written. Returns an empty string, or what is wrong with the value:
/// `must be a finite number >= 0`.
std::string set_key(const ScenarioKey& key, const SettingValue& value, Scenario& scenario);

/// The scenario in which every key that may be left out has its default: anchors are 1 although of no effect.
Scenario starting_scenario(WorldModel model);

}  // namespace credence
