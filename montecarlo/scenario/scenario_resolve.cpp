#include "montecarlo/scenario/scenario_resolve.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "montecarlo/scenario/scenario_schema.h"

namespace credence {
namespace {

const Setting* find_setting(std::span<const Setting> settings, const ScenarioKey& key) {
  const auto found = std::find_if(settings.begin(), settings.end(), [&](const Setting& setting) {
    return setting.section == key.section && setting.key == key.name;
  });
  return found == settings.end() ? nullptr : &*found;
}

/// The model, when it is given and right.
std::optional<WorldModel> chosen_model(std::span<const Setting> settings) {
  const ScenarioKey& key = *find_scenario_key("world", "model");
  const Setting* setting = find_setting(settings, key);
  Scenario scenario;
  if (setting == nullptr || !set_key(key, setting->value, scenario).empty()) return std::nullopt;
  return scenario.world.model;
}

/// Whether the key exists in worlds of the model, whatever the other settings.
bool belongs_to(const ScenarioKey& key, std::optional<WorldModel> model) {
  if (!model || key.accepted_when.find("world.model") == std::string_view::npos) return true;
  return key.accepted_when.find(to_string(*model)) != std::string_view::npos;
}

std::vector<std::string_view> names_of(std::string_view section, std::optional<WorldModel> model) {
  std::vector<std::string_view> names;
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.section == section && belongs_to(key, model)) names.push_back(key.name);
  }
  return names;
}

/// The key of this name in whatever section, as section.name.
std::string key_elsewhere(std::string_view name) {
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.name == name) return key.path();
  }
  return {};
}

std::string sections_text() { return fmt::format("[{}], [sweep]", fmt::join(scenario_sections(), "], [")); }

/// What a resolution works on: the settings, and the scenario they have made so far.
struct Resolution {
  std::span<const Setting> settings;
  const std::string& origin;
  Scenario scenario;

  /// Place and value of a key, given or by default.
  std::string place(const ScenarioKey& key) const {
    if (const Setting* setting = find_setting(settings, key)) return setting->place;
    return fmt::format("{}: [{}] {} = {} (default)", origin, key.section, key.name,
                       value_text(key_value(key, scenario)));
  }

  [[noreturn]] void impossible(std::string_view section, std::string_view name,
                               const std::string& rule) const {
    throw ImpossibleCombination(fmt::format("{}: {}", place(*find_scenario_key(section, name)), rule));
  }
};

void check_landmarks(const Resolution& r) {
  const WorldSettings& world = r.scenario.world;
  if (world.observability == Observability::partial) {
    if (world.landmarks < 1) {
      r.impossible("world", "landmarks", "must be >= 1 with world.observability = \"partial\"");
    }
  } else if (world.anchors < 1) {
    r.impossible("world", "anchors", "must be >= 1 with world.observability = \"full\"");
  }
}

void check_sensor(const Resolution& r) {
  const WorldSettings& world = r.scenario.world;
  if (world.model == WorldModel::planar && world.sensor_min_range >= world.sensor_range) {
    r.impossible("world", "sensor_min_range",
                 fmt::format("must be < world.sensor_range = {}", world.sensor_range));
  }
}

void check_filter(const Resolution& r) {
  const FilterSettings& filter = r.scenario.filter;
  if (filter.inflation == FilterInflation::full &&
      (filter.solution == InflationSolution::sequential || filter.solution == InflationSolution::drop)) {
    r.impossible("filter", "solution",
                 "needs filter.inflation = \"map\", it is \"full\"; with \"full\" accepted are \"pairwise\", "
                 "\"min-trace\"");
  }
  if (filter.inflation != FilterInflation::rank) return;
  const Index most = max_inflation_rank(block_layout(r.scenario), filter.inflation_range);
  const Index noises = r.scenario.world.model == WorldModel::planar ? 2 : 1;  // rank G
  const Index least = filter.inflation_range == InflationRange::with_vehicle ? noises : 0;
  if (filter.inflation_rank < least || filter.inflation_rank > most) {
    r.impossible(
        "filter", "inflation_rank",
        fmt::format("must be from {} to {} with world.landmarks = {} and filter.inflation_range = \"{}\"",
                    least, most, r.scenario.world.landmarks, to_string(filter.inflation_range)));
  }
}

void assign(Resolution& r) {
  for (const Setting& setting : r.settings) {
    const ScenarioKey& key = *find_scenario_key(setting.section, setting.key);
    const std::string wrong = set_key(key, setting.value, r.scenario);
    if (!wrong.empty()) throw ScenarioError(fmt::format("{}: {}", setting.place, wrong));
  }
}

void check_acceptance(const Resolution& r) {
  for (const Setting& setting : r.settings) {
    const ScenarioKey& key = *find_scenario_key(setting.section, setting.key);
    if (key.accepted(r.scenario)) continue;
    std::vector<std::string_view> names;
    for (const ScenarioKey& other : scenario_keys()) {
      if (other.section == key.section && other.accepted(r.scenario)) names.push_back(other.name);
    }
    const std::string here = names.empty() ? fmt::format("no key of [{}]", key.section)
                                           : fmt::format("{}", fmt::join(names, ", "));
    throw ScenarioError(
        fmt::format("{}: accepted only {}; here accepted: {}", setting.place, key.accepted_when, here));
  }
}

/// Two scenarios that differ in nothing that matters shall be equal.
void rest_unused(Scenario& scenario) {
  const Scenario defaults = default_scenario(scenario.world.model);
  for (const ScenarioKey& key : scenario_keys()) {
    if (!key.in_effect(scenario)) set_key(key, key_value(key, defaults), scenario);
  }
}

}  // namespace

Scenario resolve_scenario(std::span<const Setting> settings, const std::string& origin) {
  for (const Setting& setting : settings) {
    if (find_scenario_key(setting.section, setting.key) == nullptr) throw_unknown_key(setting, settings);
  }
  const ScenarioKey& model_key = *find_scenario_key("world", "model");
  if (find_setting(settings, model_key) == nullptr) {
    throw ScenarioError(
        fmt::format("{}: [world] model is missing: must be {}", origin, accepted_values(model_key)));
  }
  Resolution resolution{settings, origin,
                        starting_scenario(chosen_model(settings).value_or(WorldModel::monobot))};
  assign(resolution);
  check_acceptance(resolution);
  check_landmarks(resolution);
  check_sensor(resolution);
  check_filter(resolution);
  rest_unused(resolution.scenario);
  return resolution.scenario;
}

void throw_unknown_key(const Setting& setting, std::span<const Setting> settings) {
  const std::string path = key_elsewhere(setting.key);
  const std::string moved = path.empty() ? ";" : fmt::format(", did you mean {}?", path);
  if (setting.section.empty()) {
    throw ScenarioError(fmt::format("{}: stands in no section{} accepted sections are {}", setting.place,
                                    moved, sections_text()));
  }
  const std::vector<std::string_view> names = names_of(setting.section, chosen_model(settings));
  if (names.empty()) {
    const std::string_view close = closest_word(setting.section, scenario_sections());
    throw ScenarioError(fmt::format("{}: unknown section{} accepted are {}", setting.place,
                                    close.empty() ? ";" : fmt::format(", did you mean [{}]?", close),
                                    sections_text()));
  }
  const std::string_view close = closest_word(setting.key, names);
  throw ScenarioError(fmt::format("{}: unknown key{} [{}] accepts {}", setting.place,
                                  close.empty() ? moved : fmt::format(", did you mean {}?", close),
                                  setting.section, fmt::join(names, ", ")));
}

}  // namespace credence
