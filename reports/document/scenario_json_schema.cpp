#include "reports/document/scenario_json_schema.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

using OrderedJson = nlohmann::ordered_json;

struct FieldSchema {
  OrderedJson operator()(const RealField& field) const {
    OrderedJson schema{{"type", "number"}};
    const Interval& accepted = field.accepted;
    if (std::isfinite(accepted.low))
      schema[accepted.low_open ? "exclusiveMinimum" : "minimum"] = accepted.low;
    if (std::isfinite(accepted.high))
      schema[accepted.high_open ? "exclusiveMaximum" : "maximum"] = accepted.high;
    return schema;
  }
  OrderedJson operator()(const IntegerField& field) const {
    return {{"type", "integer"}, {"minimum", field.low}, {"maximum", field.high}};
  }
  OrderedJson operator()(const ChoiceField& field) const { return {{"enum", field.words}}; }
  OrderedJson operator()(const RowsField&) const { return {{"type", "array"}}; }
  OrderedJson operator()(const NamesField&) const {
    return {{"type", "array"}, {"items", {{"type", "string"}}}};
  }
};

/// The default of a scalar in the first world that has the key; null for others and for what must be given.
OrderedJson default_of(const ScenarioKey& key) {
  if (!key.default_words.empty()) return nullptr;
  const SettingValue value = key_value(key, starting_scenario(key.uses.front().world));
  const auto* const scalar = std::get_if<ScalarValue>(&value);
  if (scalar == nullptr) return nullptr;
  if (const auto* word = std::get_if<std::string>(scalar)) return *word;
  if (const auto* integer = std::get_if<std::int64_t>(scalar)) return *integer;
  if (const auto* real = std::get_if<double>(scalar); real != nullptr && std::isfinite(*real)) return *real;
  return nullptr;
}

OrderedJson schema_of(const ScenarioKey& key) {
  OrderedJson schema = std::visit(FieldSchema{}, key.field);
  std::string about(key.meaning);
  if (!key.unit.empty()) about += fmt::format(" ({})", key.unit);
  if (const std::string where = key.accepted_where(); !where.empty())
    about += fmt::format("; only {}", where);
  schema["description"] = std::move(about);
  if (OrderedJson value = default_of(key); !value.is_null()) schema["default"] = std::move(value);
  return schema;
}

/// The table of a section such as "study.stop", made where it is not there yet.
OrderedJson& table_of(OrderedJson& root, std::string_view section) {
  OrderedJson* table = &root;
  while (!section.empty()) {
    const std::size_t dot = std::min(section.find('.'), section.size());
    OrderedJson& inner = (*table)["properties"][std::string(section.substr(0, dot))];
    if (inner.is_null()) inner = {{"type", "object"}, {"properties", OrderedJson::object()}};
    table = &inner;
    section.remove_prefix(std::min(dot + 1, section.size()));
  }
  return *table;
}

bool of_every_world(const ScenarioKey& key) { return key.uses.size() == world_schemas().size(); }

/// Refuses the keys that worlds of this name have not, and asks for those that only they and some others
/// need.
OrderedJson rule_of(std::string_view world) {
  OrderedJson rule = {{"properties", OrderedJson::object()}};
  for (const ScenarioKey& key : scenario_keys()) {
    if (!key.of_world(world)) {
      table_of(rule, key.section)["properties"][std::string(key.name)] = false;
    } else if (key.required() && !of_every_world(key)) {
      table_of(rule, key.section)["required"].push_back(key.name);
    }
  }
  const OrderedJson model = {{"properties", {{"model", {{"const", world}}}}}, {"required", {"model"}}};
  return {{"if", {{"properties", {{"world", model}}}}}, {"then", std::move(rule)}};
}

void close_tables(OrderedJson& table) {
  table["additionalProperties"] = false;
  for (auto& [name, inner] : table["properties"].items()) {
    if (inner.contains("properties")) close_tables(inner);
  }
}

}  // namespace

std::string scenario_json_schema() {
  OrderedJson root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"title", "Scenario of Credence"},
                      {"type", "object"},
                      {"properties", OrderedJson::object()}};
  for (const ScenarioKey& key : scenario_keys()) {
    OrderedJson& table = table_of(root, key.section);
    table["properties"][std::string(key.name)] = schema_of(key);
    if (key.required() && of_every_world(key)) table["required"].push_back(key.name);
  }
  close_tables(root);
  root["required"] = {"world"};
  // Dotted keys in quotes, or tables of the sections.
  root["properties"]["sweep"] = {
      {"type", "object"},
      {"description",
       "lists of values, each an array or a text such as \"log(0.1, 10, 5)\": all combinations"}};
  root["allOf"] = OrderedJson::array();
  for (const WorldSchema* const world : world_schemas()) root["allOf"].push_back(rule_of(world->name));
  return root.dump(1) + "\n";
}

}  // namespace credence::internal
