#include "montecarlo/scenario/scenario_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::string_view> world_names() {
  std::vector<std::string_view> names;
  for (const WorldSchema* world : world_schemas()) names.push_back(world->name);
  return names;
}

/// "vehicle on a line (monobot); …".
std::string_view meaning_of_model() {
  static const std::string text = [] {
    std::vector<std::string> worlds;
    for (const WorldSchema* world : world_schemas()) {
      worlds.push_back(fmt::format("{}: {}", world->name, world->meaning));
    }
    return fmt::format("{}", fmt::join(worlds, "; "));
  }();
  return text;
}

KeyRow model_key() {
  const std::vector<std::string_view> names = world_names();
  const auto get = [names](const Scenario& s) {
    return static_cast<std::size_t>(std::ranges::find(names, s.world.model) - names.begin());
  };
  const auto set = [names](Scenario& s, std::size_t index) { s.world.model = names[index]; };
  return {.section = "world",
          .name = "model",
          .unit = "",
          .meaning = meaning_of_model(),
          .field = ChoiceField{get, set, names},
          .default_words = "required"};
}

std::vector<KeyRow> study_keys() {
  using S = StudySettings;
  constexpr auto kStudy = &Scenario::study;
  return {
      {"study", "runs", "", "independent runs", integer_field<kStudy, &S::runs>(1, 1'000'000'000)},
      {"study", "steps", "", "steps of one run", integer_field<kStudy, &S::steps>(1, 10'000'000)},
      {"study", "seed", "", "first key of all random numbers",
       integer_field<kStudy, &S::seed>(0, std::numeric_limits<std::int64_t>::max())},
      {"study", "confidence", "", "of every interval and verdict",
       real_field<kStudy, &S::confidence>({kLeastConfidence, kMostConfidence, false, false})},
  };
}

std::vector<KeyRow> stop_keys() {
  using S = StopSettings;
  constexpr auto kStop = &Scenario::stop;
  return {
      {.section = "study.stop",
       .name = "verdict",
       .unit = "",
       .meaning =
           "end the study when the filter is proved inconsistent, or either that or consistent within a "
           "factor; valid however often one looks",
       .field = choice_field<kStop, &S::verdict>(StopVerdict::either),
       .in_effect = [](const Scenario& s) { return s.stop.verdict != StopVerdict::none; }},
      {.section = "study.stop",
       .name = "consistent_within",
       .unit = "",
       .meaning = "consistent is then: one factor on all of P is proved to be within 1 + this of 1",
       .field = real_field<kStop, &S::consistent_within>(Interval::kPositive),
       .in_effect = [](const Scenario& s) { return s.stop.verdict == StopVerdict::either; }},
      {.section = "study.stop",
       .name = "precision",
       .unit = "",
       .meaning = "end the study when the mean NEES is known to this relative half-width; 0: do not",
       .field = real_field<kStop, &S::precision>(Interval::kNotNegative),
       .in_effect = [](const Scenario& s) { return s.stop.precision > 0.0; }},
      {.section = "study.stop",
       .name = "max_runs",
       .unit = "",
       .meaning = "most runs, in the place of study.runs; 0: study.runs",
       .field = integer_field<kStop, &S::max_runs>(0, 1'000'000'000),
       .in_effect = [](const Scenario& s) { return s.stop.max_runs > 0; }},
      {.section = "study.stop",
       .name = "max_seconds",
       .unit = "s",
       .meaning = "no chunk of runs is begun later; the only limit that depends on the machine; 0: none",
       .field = real_field<kStop, &S::max_seconds>(Interval::kNotNegative),
       .in_effect = [](const Scenario& s) { return s.stop.max_seconds > 0.0; }},
  };
}

void append(ScenarioKey key, std::vector<ScenarioKey>& table) {
  const auto same = std::ranges::find_if(table, [&](const ScenarioKey& other) {
    return other.section == key.section && other.name == key.name;
  });
  if (same == table.end()) {
    table.push_back(std::move(key));
  } else {
    same->uses.insert(same->uses.end(), key.uses.begin(), key.uses.end());
  }
}

/// A row of one world; a key that several worlds have is described by the first of them.
void append(const KeyRow& row, std::string_view world, std::vector<ScenarioKey>& table) {
  const auto in_effect = row.in_effect != nullptr ? row.in_effect : row.accepted;
  append(ScenarioKey{row, {{world, row.accepted, row.accepted_when, in_effect}}}, table);
}

/// In each section the worlds' keys stand between those that all worlds have.
std::vector<ScenarioKey> all_keys() {
  constexpr std::string_view kSections[] = {"world", "noise", "initial", "filter", "study", "study.stop"};
  std::vector<KeyRow> last = noise_switch_keys();
  for (auto&& rows : {study_keys(), stop_keys()}) last.insert(last.end(), rows.begin(), rows.end());
  std::vector<ScenarioKey> table;
  const auto append_common = [&](const KeyRow& row) {
    for (const WorldSchema* world : world_schemas()) append(row, world->name, table);
  };
  append_common(model_key());
  for (const std::string_view section : kSections) {
    for (const WorldSchema* world : world_schemas()) {
      for (const KeyRow& row : world->keys()) {
        if (row.section == section) append(row, world->name, table);
      }
    }
    for (const KeyRow& row : last) {
      if (row.section == section) append_common(row);
    }
  }
  return table;
}

/// Of a key whose value is an array, which may be left out.
std::optional<bool> is_given(const ScenarioKey& key, const Scenario& scenario) {
  if (const auto* rows = std::get_if<RowsField>(&key.field)) return scenario.own.contains(rows->path);
  if (const auto* names = std::get_if<NamesField>(&key.field)) return scenario.own.contains(names->path);
  return std::nullopt;
}

const ScenarioKey::Use* use_in(const ScenarioKey& key, std::string_view world) {
  const auto found = std::ranges::find(key.uses, world, &ScenarioKey::Use::world);
  return found == key.uses.end() ? nullptr : &*found;
}

std::string interval_text(const Interval& interval) {
  const std::string low = fmt::format("{} {}", interval.low_open ? ">" : ">=", interval.low);
  if (interval.high == kInfinity) return "a finite number " + low;
  return fmt::format("a number {} and {} {}", low, interval.high_open ? "<" : "<=", interval.high);
}

bool contains(const Interval& interval, double value) {
  return std::isfinite(value) && (interval.low_open ? value > interval.low : value >= interval.low) &&
         (interval.high_open ? value < interval.high : value <= interval.high);
}

std::string words_text(const ChoiceField& field) {
  std::string text = "one of";
  for (const std::string_view word : field.words) {
    text += fmt::format("{} \"{}\"", text.back() == 'f' ? "" : ",", word);
  }
  return text;
}

struct AcceptedText {
  std::string operator()(const RealField& field) const { return interval_text(field.accepted); }
  std::string operator()(const IntegerField& field) const {
    return fmt::format("an integer from {} to {}", field.low, field.high);
  }
  std::string operator()(const ChoiceField& field) const { return words_text(field); }
  std::string operator()(const RowsField&) const { return "a matrix of finite numbers, [[row], [row], …]"; }
  std::string operator()(const NamesField&) const { return "an array of different names"; }
};

SettingValue setting_of(const NumberRows& rows) {
  if (rows.empty()) return std::vector<ScalarValue>{};
  NestedArray value;
  for (const std::vector<double>& row : rows) value.emplace_back(row.begin(), row.end());
  return value;
}

struct FieldValue {
  const Scenario& scenario;

  SettingValue operator()(const RealField& field) const { return field.get(scenario); }
  SettingValue operator()(const IntegerField& field) const { return field.get(scenario); }
  SettingValue operator()(const ChoiceField& field) const {
    return std::string(field.words[field.get(scenario)]);
  }
  SettingValue operator()(const RowsField& field) const {
    return setting_of(rows_value(scenario, field.path));
  }
  SettingValue operator()(const NamesField& field) const {
    const std::vector<std::string> names = names_value(scenario, field.path);
    return std::vector<ScalarValue>(names.begin(), names.end());
  }
};

struct FieldCopy {
  const Scenario& from;
  Scenario& to;

  template <class Field>
  void operator()(const Field& field) const {
    if constexpr (requires { field.path; }) {
      to.own.erase(field.path);
      if (const auto found = from.own.find(field.path); found != from.own.end()) to.own.insert(*found);
    } else {
      field.set(to, field.get(from));
    }
  }
};

/// A finite number, whole or not.
std::optional<double> number_of(const ScalarValue& value) {
  std::optional<double> number;
  if (const auto* real = std::get_if<double>(&value)) number = *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) number = static_cast<double>(*whole);
  return number && std::isfinite(*number) ? std::optional(*number + 0.0) : std::nullopt;
}

/// Sets one field; what it returns is as for set_key.
struct Setter {
  const SettingValue& value;
  Scenario& scenario;

  template <class T>
  const T* scalar() const {
    const auto* any = std::get_if<ScalarValue>(&value);
    return any == nullptr ? nullptr : std::get_if<T>(any);
  }

  std::string refuse(const std::string& accepted) const { return fmt::format("must be {}", accepted); }
  std::string refuse_type(const std::string& accepted) const {
    const std::string_view type = type_text(value);
    return fmt::format("must be {}, not {}{}{}", accepted, type, type.empty() ? "" : " ", value_text(value));
  }

  std::string operator()(const RealField& field) const {
    double number = 0.0;
    if (const auto* real = scalar<double>()) {
      number = *real;
    } else if (const auto* whole = scalar<std::int64_t>()) {
      number = static_cast<double>(*whole);
    } else {
      return refuse_type(interval_text(field.accepted));
    }
    if (!contains(field.accepted, number)) return refuse(interval_text(field.accepted));
    field.set(scenario, number + 0.0);  // -0 would be another text for the same value
    return {};
  }

  std::string operator()(const IntegerField& field) const {
    const auto* whole = scalar<std::int64_t>();
    if (whole == nullptr) return refuse_type(AcceptedText{}(field));
    if (*whole < field.low || *whole > field.high) return refuse(AcceptedText{}(field));
    field.set(scenario, *whole);
    return {};
  }

  std::string operator()(const ChoiceField& field) const {
    const auto* word = scalar<std::string>();
    if (word == nullptr) return refuse_type(words_text(field));
    const auto found = std::find(field.words.begin(), field.words.end(), *word);
    if (found == field.words.end()) {
      const std::string_view close = closest_word(*word, field.words);
      return refuse(words_text(field)) + (close.empty() ? "" : fmt::format("; did you mean \"{}\"?", close));
    }
    field.set(scenario, static_cast<std::size_t>(found - field.words.begin()));
    return {};
  }

  std::string operator()(const RowsField& field) const {
    const auto* rows = std::get_if<NestedArray>(&value);
    if (rows == nullptr) return refuse_type(AcceptedText{}(field));
    NumberRows numbers;
    for (const std::vector<ScalarValue>& row : *rows) {
      std::vector<double>& into = numbers.emplace_back();
      for (const ScalarValue& element : row) {
        const std::optional<double> number = number_of(element);
        if (!number) {
          return refuse(fmt::format("{}; row {}, column {} is {}", AcceptedText{}(field), numbers.size(),
                                    into.size() + 1, value_text(element)));
        }
        into.push_back(*number);
      }
    }
    scenario.own[field.path] = std::move(numbers);
    return {};
  }

  std::string operator()(const NamesField& field) const {
    const auto* list = std::get_if<std::vector<ScalarValue>>(&value);
    if (list == nullptr || list->empty()) return refuse_type(AcceptedText{}(field));
    std::vector<std::string> names;
    for (const ScalarValue& element : *list) {
      const auto* name = std::get_if<std::string>(&element);
      if (name == nullptr || name->empty() || std::ranges::find(names, *name) != names.end()) {
        return refuse(fmt::format("{}; element {} is {}", AcceptedText{}(field), names.size() + 1,
                                  value_text(element)));
      }
      names.push_back(*name);
    }
    scenario.own[field.path] = std::move(names);
    return {};
  }
};

}  // namespace

const Interval Interval::kPositive{0.0, kInfinity, true, true};
const Interval Interval::kNotNegative{0.0, kInfinity, false, true};

std::string ScenarioKey::path() const { return fmt::format("{}.{}", section, name); }

bool ScenarioKey::of_world(std::string_view world) const { return use_in(*this, world) != nullptr; }

bool ScenarioKey::accepted_in(const Scenario& scenario) const {
  const Use* const use = use_in(*this, scenario.world.model);
  return use != nullptr && (use->accepted == nullptr || use->accepted(scenario));
}

bool ScenarioKey::in_effect_in(const Scenario& scenario) const {
  const Use* const use = use_in(*this, scenario.world.model);
  if (use == nullptr) return false;
  if (const std::optional<bool> given = is_given(*this, scenario)) return *given;
  return use->in_effect == nullptr || use->in_effect(scenario);
}

std::string ScenarioKey::accepted_where() const {
  std::vector<std::string> plain, places;
  for (const Use& use : uses) {
    if (use.accepted_when.empty()) {
      plain.push_back(fmt::format("\"{}\"", use.world));
    } else if (std::ranges::find(places, use.accepted_when) == places.end()) {
      places.emplace_back(use.accepted_when);
    }
  }
  if (plain.size() == world_schemas().size()) return {};
  if (!plain.empty()) {
    places.insert(places.begin(), fmt::format("with world.model = {}", fmt::join(plain, " or ")));
  }
  return fmt::format("{}", fmt::join(places, ", or "));
}

std::span<const ScenarioKey> scenario_keys() {
  static const std::vector<ScenarioKey> keys = all_keys();
  return keys;
}

std::vector<std::string_view> scenario_sections() {
  std::vector<std::string_view> sections;
  for (const ScenarioKey& key : scenario_keys()) {
    if (sections.empty() || sections.back() != key.section) sections.push_back(key.section);
  }
  return sections;
}

const ScenarioKey* find_scenario_key(std::string_view section, std::string_view name) {
  const auto keys = scenario_keys();
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const ScenarioKey& key) {
    return key.section == section && key.name == name;
  });
  return found == keys.end() ? nullptr : &*found;
}

std::string accepted_values(const ScenarioKey& key) { return std::visit(AcceptedText{}, key.field); }

SettingValue key_value(const ScenarioKey& key, const Scenario& scenario) {
  return std::visit(FieldValue{scenario}, key.field);
}

std::string set_key(const ScenarioKey& key, const SettingValue& value, Scenario& scenario) {
  return std::visit(Setter{value, scenario}, key.field);
}

void copy_key(const ScenarioKey& key, const Scenario& from, Scenario& to) {
  std::visit(FieldCopy{from, to}, key.field);
}

Scenario starting_scenario(std::string_view model) {
  Scenario scenario = default_scenario(model);
  scenario.world.anchors = 1;
  return scenario;
}

}  // namespace credence::internal
