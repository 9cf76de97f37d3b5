#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_value.h"

/// @file
/// The one table of all keys of a scenario: those that every world has, and the rows that the worlds state
/// themselves (world_schema.h). Reading, checking, the canonical text, the help text and the reference page
/// come from it; a new key is a new row.

namespace credence::internal {

/// The finite numbers between two bounds.
struct Interval {
  double low, high;
  bool low_open, high_open;  ///< whether the bound itself is excluded

  static const Interval kPositive, kNotNegative;
};

struct RealField {
  std::function<double(const Scenario&)> get;
  std::function<void(Scenario&, double)> set;
  Interval accepted;
};
struct IntegerField {
  std::function<std::int64_t(const Scenario&)> get;
  std::function<void(Scenario&, std::int64_t)> set;
  std::int64_t low, high;
};
struct ChoiceField {
  std::function<std::size_t(const Scenario&)> get;
  std::function<void(Scenario&, std::size_t)> set;
  std::vector<std::string_view> words;  ///< in the order of the enum
};
/// A matrix as an array of rows, empty where it is not given. A world checks its shape.
struct RowsField {
  std::string path;  ///< section.name
};
/// An array of words, empty where it is not given.
struct NamesField {
  std::string path;
};
using KeyField = std::variant<RealField, IntegerField, ChoiceField, RowsField, NamesField>;

/// A row of the table, as a world or the common part of the table states it.
struct KeyRow {
  std::string_view section;
  std::string_view name;
  std::string_view unit;     ///< empty for a pure number or word
  std::string_view meaning;  ///< one sentence
  KeyField field;
  bool (*accepted)(const Scenario&) = nullptr;  ///< whether it may be given in this world; null: always
  std::string_view accepted_when{};  ///< the same in words, with the world if need be; empty: in this world
  bool (*in_effect)(const Scenario&) = nullptr;  ///< else it rests at its default; null: where accepted
  std::string_view default_words{};              ///< in the place of the value; "required": it must be given
};

/// One key, with the worlds that have it.
struct ScenarioKey : KeyRow {
  /// What one world says of it.
  struct Use {
    std::string_view world;
    bool (*accepted)(const Scenario&);
    std::string_view accepted_when;
    bool (*in_effect)(const Scenario&);
  };
  std::vector<Use> uses;

  std::string path() const;  ///< section.name
  bool required() const { return default_words == "required"; }

  /// Whether worlds of this name have the key, whatever the other settings.
  bool of_world(std::string_view world) const;
  /// Whether the key may be given in such a scenario.
  bool accepted_in(const Scenario& scenario) const;
  /// Whether it plays a part; else it rests at its default.
  bool in_effect_in(const Scenario& scenario) const;
  /// Where it is accepted, in words; empty: always.
  std::string accepted_where() const;
};

/// All keys, in canonical order.
std::span<const ScenarioKey> scenario_keys();

/// The sections, in canonical order.
std::vector<std::string_view> scenario_sections();

/// The key `section.name`, or nullptr.
const ScenarioKey* find_scenario_key(std::string_view section, std::string_view name);

/// What a key accepts in words: `a finite number >= 0`, `one of "none", "full", "map", "rank"`.
std::string accepted_values(const ScenarioKey& key);

/// The value of a key in a resolved scenario, words as strings; an empty array for a matrix not given.
SettingValue key_value(const ScenarioKey& key, const Scenario& scenario);

/// Sets a key from a value as written. Returns an empty string, or what is wrong with the value:
/// `must be a finite number >= 0`.
std::string set_key(const ScenarioKey& key, const SettingValue& value, Scenario& scenario);

/// Copies the value of one key.
void copy_key(const ScenarioKey& key, const Scenario& from, Scenario& to);

/// The scenario in which every key that may be left out has its default: anchors are 1 although of no effect.
Scenario starting_scenario(std::string_view model);

}  // namespace credence::internal
