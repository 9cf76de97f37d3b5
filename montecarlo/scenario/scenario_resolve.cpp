#include "montecarlo/scenario/scenario_resolve.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "core/names_in.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

const Setting* find_setting(std::span<const Setting> settings, const ScenarioKey& key) {
  const auto found = std::find_if(settings.begin(), settings.end(), [&](const Setting& setting) {
    return setting.section == key.section && setting.key == key.name;
  });
  return found == settings.end() ? nullptr : &*found;
}

/// The model, when it is given and right.
std::optional<std::string> chosen_model(std::span<const Setting> settings) {
  const ScenarioKey& key = *find_scenario_key("world", "model");
  const Setting* setting = find_setting(settings, key);
  Scenario scenario;
  if (setting == nullptr || !set_key(key, setting->value, scenario).empty()) return std::nullopt;
  return scenario.world.model;
}

std::vector<std::string_view> names_of(std::string_view section, const std::optional<std::string>& model) {
  std::vector<std::string_view> names;
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.section == section && (!model || key.of_world(*model))) names.push_back(key.name);
  }
  return names;
}

/// The keys of this name in whatever sections, as "world.Q or filter.Q".
std::string keys_elsewhere(std::string_view name) {
  std::vector<std::string> paths;
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.name == name) paths.push_back(key.path());
  }
  return fmt::format("{}", fmt::join(paths, " or "));
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

  template <class Error>
  Refusal::Throw refuse() const {
    return [this](std::string_view section, std::string_view name, const std::string& rule) {
      throw Error(fmt::format("{}: {}", place(*find_scenario_key(section, name)), rule));
    };
  }

  void check() const {
    const Refusal refusal{refuse<ImpossibleCombination>(), refuse<ScenarioError>()};
    check_noise_switches(scenario, refusal);
    const WorldSchema& world = *find_world(scenario.world.model);
    if (world.check != nullptr) world.check(scenario, refusal);
  }
};

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
    if (key.accepted_in(r.scenario)) continue;
    std::vector<std::string_view> names;
    for (const ScenarioKey& other : scenario_keys()) {
      if (other.section == key.section && other.accepted_in(r.scenario)) names.push_back(other.name);
    }
    const std::string here = names.empty() ? fmt::format("no key of [{}]", key.section)
                                           : fmt::format("{}", fmt::join(names, ", "));
    throw ScenarioError(
        fmt::format("{}: accepted only {}; here accepted: {}", setting.place, key.accepted_where(), here));
  }
}

void require(const ScenarioKey& key, std::span<const Setting> settings, const std::string& origin) {
  if (find_setting(settings, key) != nullptr) return;
  throw ScenarioError(
      fmt::format("{}: [{}] {} is missing: must be {}", origin, key.section, key.name, accepted_values(key)));
}

/// Two scenarios that differ in nothing that matters shall be equal.
void rest_unused(Scenario& scenario) {
  const Scenario defaults = default_scenario(scenario.world.model);
  for (const ScenarioKey& key : scenario_keys()) {
    if (!key.in_effect_in(scenario)) copy_key(key, defaults, scenario);
  }
}

}  // namespace

Scenario resolve_scenario(std::span<const Setting> settings, const std::string& origin) {
  for (const Setting& setting : settings) {
    if (find_scenario_key(setting.section, setting.key) == nullptr) throw_unknown_key(setting, settings);
  }
  const ScenarioKey& model_key = *find_scenario_key("world", "model");
  require(model_key, settings, origin);
  Resolution resolution{settings, origin,
                        starting_scenario(chosen_model(settings).value_or(Scenario().world.model))};
  assign(resolution);
  check_acceptance(resolution);
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.required() && key.accepted_in(resolution.scenario)) require(key, settings, origin);
  }
  resolution.check();
  rest_unused(resolution.scenario);
  return resolution.scenario;
}

std::string keys_without_section(std::string_view name) {
  if (std::string path = keys_elsewhere(name); !path.empty()) return path;
  const std::string_view close = closest_word(name, names_in(scenario_keys()));
  return close.empty() ? "" : keys_elsewhere(close);
}

void throw_unknown_key(const Setting& setting, std::span<const Setting> settings) {
  const auto meant = [](const std::string& path) {
    return path.empty() ? ";" : fmt::format(", did you mean {}?", path);
  };
  if (setting.section.empty()) {
    throw ScenarioError(fmt::format("{}: stands in no section{} accepted sections are {}", setting.place,
                                    meant(keys_without_section(setting.key)), sections_text()));
  }
  const std::vector<std::string_view> names = names_of(setting.section, chosen_model(settings));
  if (names.empty()) {
    std::vector<std::string_view> sections = scenario_sections();
    sections.emplace_back("sweep");
    const std::string_view close = closest_word(setting.section, sections);
    throw ScenarioError(fmt::format("{}: unknown section{} accepted are {}", setting.place,
                                    close.empty() ? ";" : fmt::format(", did you mean [{}]?", close),
                                    sections_text()));
  }
  const std::string section = fmt::format("{}.{}", setting.section, setting.key);
  if (std::ranges::count(scenario_sections(), section) > 0) {
    throw ScenarioError(fmt::format("{}: is a section, [{}], and no value; it accepts {}", setting.place,
                                    section, fmt::join(names_of(section, chosen_model(settings)), ", ")));
  }
  const std::string_view close = closest_word(setting.key, names);
  throw ScenarioError(fmt::format("{}: unknown key{} [{}] accepts {}", setting.place,
                                  meant(close.empty() ? keys_elsewhere(setting.key) : std::string(close)),
                                  setting.section, fmt::join(names, ", ")));
}

}  // namespace credence::internal
