#include "montecarlo/scenario/scenario_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

Scenario text_scenario(const std::vector<std::string>& overrides, const std::string& name = "t.toml") {
  return load_scenario_text("[world]\nmodel = \"monobot\"\n", name, overrides);
}

TEST(ScenarioText, OfEveryWorldReadsBackTheSame) {
  for (const WorldSchema* world : world_schemas()) {
    if (world->name == "linear") continue;  // has no default: its matrices must be given
    const Scenario scenario = default_scenario(world->name);
    const std::string text = canonical_toml(scenario);
    Scenario again = load_scenario_text(text, "again.toml");
    again.name = scenario.name;
    EXPECT_EQ(canonical_toml(again), text) << world->name;
    EXPECT_EQ(configuration_id(again), configuration_id(scenario)) << world->name;
  }
}

TEST(ScenarioText, HasNoKeyThatPlaysNoPart) {
  EXPECT_THAT(canonical_toml(text_scenario({})), Not(HasSubstr("anchors")));
  EXPECT_THAT(canonical_toml(text_scenario({"world.observability=full"})), HasSubstr("anchors = 1\n"));
  EXPECT_THAT(canonical_toml(text_scenario({})), Not(HasSubstr("inflation_rank")));
}

TEST(ScenarioText, IdentityIsTheHashOfWhatARunDependsOn) {
  // FNV-1a of 64 bits, from its two constants (Fowler, Noll, Vo).
  const Scenario scenario = text_scenario({});
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : configuration_toml(scenario)) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  }
  std::string digits;
  for (int i = 0; i < 16; ++i, hash >>= 4U) digits.insert(digits.begin(), "0123456789abcdef"[hash & 15U]);
  EXPECT_EQ(configuration_id(scenario), digits);

  for (const char* same : {"study.runs=7", "study.confidence=0.9", "study.stop.verdict=either",
                           "study.stop.max_runs=9", "world.model=monobot"}) {
    EXPECT_EQ(configuration_id(text_scenario({same})), digits) << same;
  }
  EXPECT_EQ(configuration_id(text_scenario({}, "another/name.toml")), digits);
  for (const char* other : {"study.seed=2", "study.steps=7", "filter.process_scale=2", "world.landmarks=3",
                            "noise.process_variance=0.2"}) {
    EXPECT_NE(configuration_id(text_scenario({other})), digits) << other;
  }
}

TEST(ScenarioText, NoiseIsThatOfTheWorldWhateverFilterAndStudyAre) {
  const std::uint64_t group = noise_group(text_scenario({}));
  for (const char* same :
       {"study.seed=2", "study.steps=7", "study.runs=9", "filter.process_scale=2", "filter.inflation=map"}) {
    EXPECT_EQ(noise_group(text_scenario({same})), group) << same;
  }
  for (const char* other : {"world.landmarks=3", "noise.measurement_variance=0.2"}) {
    EXPECT_NE(noise_group(text_scenario({other})), group) << other;
  }
}

TEST(ScenarioText, JsonHasItsSectionsNested) {
  const Scenario scenario =
      text_scenario({"study.stop.verdict=either", "noise.process_variance=0.1", "study.seed=7"}, "odd.toml");
  const auto json = nlohmann::json::parse(scenario_to_json(scenario));
  EXPECT_EQ(json["name"], "odd");
  EXPECT_EQ(json["world"]["model"], "monobot");
  EXPECT_EQ(json["noise"]["process_variance"], 0.1);
  EXPECT_TRUE(json["noise"]["process_variance"].is_number_float());
  EXPECT_TRUE(json["study"]["seed"].is_number_integer());
  EXPECT_EQ(json["study"]["stop"]["verdict"], "either");
}

TEST(ScenarioText, JsonOfAnyFileNameIsJson) {
  Scenario scenario = text_scenario({});
  scenario.name = "a\"b\\\n\xff\xfe";
  const auto json = nlohmann::json::parse(scenario_to_json(scenario));
  EXPECT_THAT(json["name"].get<std::string>(), testing::StartsWith("a\"b\\\n"));
}

}  // namespace
}  // namespace credence::internal
