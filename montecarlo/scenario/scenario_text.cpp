#include "montecarlo/scenario/scenario_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "montecarlo/scenario/scenario_hash.h"
#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {
namespace {

/// The canonical text of those keys in effect that `wanted` names.
template <class Predicate>
std::string text_of(const Scenario& scenario, Predicate wanted) {
  std::string text;
  std::string_view section;
  for (const ScenarioKey& key : scenario_keys()) {
    if (!key.in_effect_in(scenario) || !wanted(key)) continue;
    if (key.section != section) {
      section = key.section;
      text += fmt::format("[{}]\n", section);
    }
    text += fmt::format("{} = {}\n", key.name, full_text(key_value(key, scenario)));
  }
  return text;
}

nlohmann::ordered_json json_value(const ScalarValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return *integer;
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::get<std::string>(value);
}

nlohmann::ordered_json json_value(const std::vector<ScalarValue>& values) {
  auto json = nlohmann::ordered_json::array();
  for (const ScalarValue& value : values) json.push_back(json_value(value));
  return json;
}

nlohmann::ordered_json json_value(const NestedArray& rows) {
  auto json = nlohmann::ordered_json::array();
  for (const std::vector<ScalarValue>& row : rows) json.push_back(json_value(row));
  return json;
}

}  // namespace

std::string canonical_toml(const Scenario& scenario) {
  return text_of(scenario, [](const ScenarioKey&) { return true; });
}

std::string scenario_to_json(const Scenario& scenario) {
  nlohmann::ordered_json json;
  json["name"] = scenario.name;
  for (const ScenarioKey& key : scenario_keys()) {
    if (!key.in_effect_in(scenario)) continue;
    nlohmann::ordered_json* section = &json;
    for (std::string_view rest = key.section; !rest.empty();) {
      const std::string_view name = rest.substr(0, rest.find('.'));
      rest.remove_prefix(std::min(name.size() + 1, rest.size()));
      section = &(*section)[std::string(name)];
    }
    (*section)[std::string(key.name)] =
        std::visit([](const auto& value) { return json_value(value); }, key_value(key, scenario));
  }
  return json.dump(-1, ' ', false,
                   nlohmann::ordered_json::error_handler_t::replace);  // a file may be named anything
}

std::string configuration_toml(const Scenario& scenario) {
  return text_of(scenario, [](const ScenarioKey& key) {
    return key.section != "study.stop" && key.path() != "study.runs" && key.path() != "study.confidence";
  });
}

std::string configuration_id(const Scenario& scenario) {
  return fmt::format("{:016x}", stable_hash(configuration_toml(scenario)));
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

std::uint64_t noise_group(const Scenario& scenario) {
  return stable_hash(text_of(scenario, [](const ScenarioKey& key) {
    return key.section == "world" || key.section == "noise" || key.section == "initial";
  }));
}

}  // namespace credence
