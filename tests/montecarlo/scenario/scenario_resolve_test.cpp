#include "montecarlo/scenario/scenario_resolve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Setting given(const std::string& section, const std::string& key, const ScalarValue& value) {
  return {section, key, value, "here: [" + section + "] " + key};
}
Setting of_model(const std::string& name) { return given("world", "model", name); }

/// What is said, and whether a sweep may leave such a point out.
struct Refused {
  std::string text = "accepted";
  bool impossible = false;
};

Refused refused(const std::vector<Setting>& settings) {
  try {
    resolve_scenario(settings, "t.toml");
  } catch (const ImpossibleCombination& error) {
    return {error.what(), true};
  } catch (const ScenarioError& error) {
    return {error.what(), false};
  }
  return {};
}

TEST(ScenarioResolve, WhatIsNotGivenHasItsDefault) {
  const Scenario scenario = resolve_scenario(
      std::vector{of_model("planar"), given("study", "runs", std::int64_t{7}), given("world", "dt", 0.5)},
      "t.toml");
  Scenario expected = default_scenario("planar");
  expected.study.runs = 7;
  expected.world.dt = 0.5;
  EXPECT_EQ(scenario, expected);
}

TEST(ScenarioResolve, OrderOfSettingsDoesNotMatter) {
  const std::vector settings{given("world", "anchors", std::int64_t{3}),
                             given("world", "observability", std::string("full")), of_model("monobot")};
  const std::vector<Setting> reversed(settings.rbegin(), settings.rend());
  EXPECT_EQ(resolve_scenario(settings, "t.toml"), resolve_scenario(reversed, "t.toml"));
  EXPECT_EQ(resolve_scenario(settings, "t.toml").world.anchors, 3);
}

TEST(ScenarioResolve, WhatPlaysNoPartRests) {
  const Scenario scenario = resolve_scenario(
      std::vector{of_model("monobot"), given("world", "anchors", std::int64_t{3})}, "t.toml");
  EXPECT_EQ(scenario, default_scenario("monobot")) << "anchors are of no effect where all is a state";
}

TEST(ScenarioResolve, AModelIsNeededAndIsAWorld) {
  EXPECT_THAT(refused({}).text, StartsWith("t.toml: [world] model is missing: must be one of \"monobot\""));
  EXPECT_THAT(refused({of_model("moon")}).text,
              StartsWith("here: [world] model: must be one of \"monobot\""));
}

TEST(ScenarioResolve, AnUnknownKeyIsProposed) {
  EXPECT_THAT(
      refused({of_model("monobot"), given("world", "landmark", std::int64_t{2})}).text,
      StartsWith("here: [world] landmark: unknown key, did you mean landmarks? [world] accepts model"));
  EXPECT_THAT(refused({of_model("monobot"), given("study", "landmarks", std::int64_t{2})}).text,
              HasSubstr("did you mean world.landmarks?"));
  EXPECT_THAT(refused({of_model("monobot"), given("study", "stop", std::int64_t{3})}).text,
              StartsWith("here: [study] stop: is a section, [study.stop], and no value; it accepts "));
  EXPECT_THAT(refused({of_model("monobot"), given("studdy", "nothing", std::int64_t{2})}).text,
              HasSubstr("unknown section, did you mean [study]? accepted are [world]"));
  EXPECT_THAT(refused({of_model("monobot"), given("", "runs", std::int64_t{2})}).text,
              HasSubstr("stands in no section, did you mean study.runs? accepted sections are [world]"));
  EXPECT_THAT(refused({of_model("monobot"), given("", "measurment_scale", 2.0)}).text,
              HasSubstr("stands in no section, did you mean filter.measurement_scale?"));
  EXPECT_THAT(refused({of_model("monobot"), given("sweeep", "mode", std::string("zip"))}).text,
              HasSubstr("unknown section, did you mean [sweep]? accepted are [world]"));
  // The keys of this world, not of all.
  EXPECT_THAT(refused({of_model("monobot"), given("world", "qqqqqq", 1.0)}).text,
              testing::Not(HasSubstr("sensor_range")));
}

TEST(ScenarioResolve, ANameWithoutItsSectionMeansEveryKeyOfThatNameOrTheNearest) {
  EXPECT_EQ(keys_without_section("measurement_scale"), "filter.measurement_scale");
  EXPECT_EQ(keys_without_section("measurment_scale"), "filter.measurement_scale");
  EXPECT_THAT(keys_without_section("Q"),
              testing::AllOf(HasSubstr("world.Q"), HasSubstr(" or "), HasSubstr("filter.Q")));
  EXPECT_EQ(keys_without_section("qqqqqqqqqq"), "");
}

TEST(ScenarioResolve, ANameOfAnotherWorldSaysOfWhich) {
  const Refused other = refused({of_model("monobot"), given("world", "sensor_range", 5.0)});
  EXPECT_THAT(other.text,
              StartsWith("here: [world] sensor_range: accepted only with world.model = \"planar\""));
  EXPECT_THAT(other.text, HasSubstr("here accepted: model, landmarks"));
  EXPECT_FALSE(other.impossible);
}

TEST(ScenarioResolve, ValuesAreOfTheirTypeAndRange) {
  EXPECT_EQ(refused({of_model("monobot"), given("study", "runs", std::string("many"))}).text.substr(0, 19),
            "here: [study] runs:");
  EXPECT_THAT(refused({of_model("monobot"), given("noise", "process_variance", -1.0)}).text,
              HasSubstr("must be a finite number >= 0"));
  EXPECT_THAT(refused({of_model("monobot"), given("world", "landmarks", std::int64_t{-1})}).text,
              HasSubstr("from 0 to 1000000"));
}

TEST(ScenarioResolve, WhatExcludesEachOtherMayBeLeftOutOfASweep) {
  const Refused given_one = refused({of_model("monobot"), given("world", "landmarks", std::int64_t{0})});
  EXPECT_TRUE(given_one.impossible);
  EXPECT_THAT(given_one.text, StartsWith("here: [world] landmarks: must be >= 1"));
  // A value that nobody gave is named with the file, and as a default.
  const Refused by_default = refused({of_model("monobot"), given("filter", "inflation", std::string("rank")),
                                      given("world", "landmarks", std::int64_t{1}),
                                      given("filter", "inflation_range", std::string("difference"))});
  EXPECT_TRUE(by_default.impossible);
  EXPECT_THAT(by_default.text,
              StartsWith("t.toml: [filter] inflation_rank = 1 (default): must be from 0 to 0"));
}

}  // namespace
}  // namespace credence::internal
