#include "reports/document/scenario_json_schema.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

nlohmann::json schema() { return nlohmann::json::parse(scenario_json_schema()); }

/// The property of a key, or null.
nlohmann::json property(const nlohmann::json& root, const std::string& section, const std::string& name) {
  nlohmann::json table = root;
  for (std::size_t begin = 0; begin <= section.size();) {
    const std::size_t end = std::min(section.find('.', begin), section.size());
    table = table["properties"][section.substr(begin, end - begin)];
    begin = end + 1;
  }
  return table["properties"][name];
}

TEST(ScenarioJsonSchema, EveryKeyIsThereWithItsMeaningAndItsBounds) {
  const nlohmann::json root = schema();
  EXPECT_EQ(root["$schema"], "https://json-schema.org/draft/2020-12/schema");
  for (const ScenarioKey& key : scenario_keys()) {
    const nlohmann::json of = property(root, std::string(key.section), std::string(key.name));
    ASSERT_TRUE(of.is_object()) << key.section << '.' << key.name;
    EXPECT_TRUE(of["description"].get<std::string>().starts_with(std::string(key.meaning)));
    if (const auto* real = std::get_if<RealField>(&key.field)) {
      EXPECT_EQ(of["type"], "number");
      EXPECT_EQ(of.contains("minimum") || of.contains("exclusiveMinimum"), std::isfinite(real->accepted.low));
      EXPECT_FALSE(of.contains("minimum") && of.contains("exclusiveMinimum"));
      if (real->accepted.low_open) EXPECT_FALSE(of.contains("minimum"));
    }
    // A default must be accepted by its own schema.
    if (!of.contains("default")) continue;
    if (of.contains("enum"))
      EXPECT_THAT(of["enum"].get<std::vector<nlohmann::json>>(), testing::Contains(of["default"]));
    if (of.contains("minimum")) EXPECT_GE(of["default"], of["minimum"]) << key.name;
    if (of.contains("exclusiveMinimum")) EXPECT_GT(of["default"], of["exclusiveMinimum"]) << key.name;
    if (of.contains("maximum")) EXPECT_LE(of["default"], of["maximum"]) << key.name;
    if (of.contains("exclusiveMaximum")) EXPECT_LT(of["default"], of["exclusiveMaximum"]) << key.name;
  }
}

TEST(ScenarioJsonSchema, AnUnknownKeyIsRefusedInEveryTable) {
  const nlohmann::json root = schema();
  EXPECT_EQ(root["additionalProperties"], false);
  for (const ScenarioKey& key : scenario_keys()) {
    nlohmann::json table = root;
    const std::string section(key.section);
    for (std::size_t begin = 0; begin <= section.size();) {
      const std::size_t end = std::min(section.find('.', begin), section.size());
      table = table["properties"][section.substr(begin, end - begin)];
      EXPECT_EQ(table["additionalProperties"], false) << section;
      begin = end + 1;
    }
  }
  EXPECT_TRUE(root["properties"].contains("sweep"));
  EXPECT_FALSE(root["properties"]["sweep"].contains("additionalProperties"))
      << "its keys are any dotted ones";
}

TEST(ScenarioJsonSchema, EachWorldRefusesTheKeysThatItHasNotAndAsksForItsOwn) {
  const nlohmann::json root = schema();
  ASSERT_EQ(root["allOf"].size(), world_schemas().size());
  std::size_t refused = 0, asked = 0;
  for (std::size_t w = 0; w < world_schemas().size(); ++w) {
    const std::string_view world = world_schemas()[w]->name;
    const nlohmann::json& rule = root["allOf"][w];
    EXPECT_EQ(rule["if"]["properties"]["world"]["properties"]["model"]["const"], std::string(world));
    for (const ScenarioKey& key : scenario_keys()) {
      const bool is_refused =
          property(rule["then"], std::string(key.section), std::string(key.name)) == nlohmann::json(false);
      EXPECT_EQ(is_refused, !key.of_world(world)) << world << ' ' << key.name;
      refused += is_refused ? 1 : 0;
    }
    const nlohmann::json& tables = rule["then"]["properties"];
    if (tables.contains("world") && tables["world"].contains("required"))
      asked += tables["world"]["required"].size();
  }
  EXPECT_GT(refused, 0U);
  EXPECT_GT(asked, 0U) << "a linear world needs its matrices";
}

TEST(ScenarioJsonSchema, EndsWithItsLine) { EXPECT_TRUE(scenario_json_schema().ends_with("}\n")); }

}  // namespace
}  // namespace credence::internal
