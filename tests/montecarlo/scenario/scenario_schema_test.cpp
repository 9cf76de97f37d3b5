#include "montecarlo/scenario/scenario_schema.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using SchemaNames = std::vector<ScalarValue>;

/// A key that no world has, of this field.
ScenarioKey key_of(KeyField field) {
  ScenarioKey key;
  key.section = "made";
  key.name = "up";
  key.field = std::move(field);
  return key;
}

/// A real key kept in study.confidence.
ScenarioKey real_key_in(Interval interval) {
  return key_of(RealField{[](const Scenario& s) { return s.study.confidence; },
                          [](Scenario& s, double value) { s.study.confidence = value; }, interval});
}

const ScenarioKey& known_key(std::string_view section, std::string_view name) {
  const ScenarioKey* key = find_scenario_key(section, name);
  if (key == nullptr) throw std::logic_error("no key " + std::string(name));
  return *key;
}

TEST(ScenarioSchema, ABoundIsExcludedWhereItIsOpen) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Scenario s;
  for (const bool low_open : {false, true}) {
    for (const bool high_open : {false, true}) {
      const ScenarioKey key = real_key_in({-1.0, 2.0, low_open, high_open});
      EXPECT_EQ(set_key(key, ScalarValue(-1.0), s).empty(), !low_open);
      EXPECT_EQ(set_key(key, ScalarValue(std::int64_t{2}), s).empty(), !high_open);
      EXPECT_EQ(set_key(key, ScalarValue(1.999), s), "");
      EXPECT_EQ(s.study.confidence, 1.999);
      EXPECT_NE(set_key(key, ScalarValue(std::nan("")), s), "");
    }
  }
  EXPECT_EQ(accepted_values(real_key_in({-1.0, 2.0, false, true})), "a number >= -1 and < 2");
  EXPECT_EQ(accepted_values(real_key_in(Interval::kPositive)), "a finite number > 0");
  EXPECT_EQ(set_key(real_key_in(Interval::kNotNegative), ScalarValue(kInfinity), s),
            "must be a finite number >= 0");
  EXPECT_EQ(s.study.confidence, 1.999) << "what is refused changes nothing";
}

// −0 is written as another text than 0, and would be another configuration.
TEST(ScenarioSchema, MinusZeroIsZero) {
  Scenario s;
  ASSERT_EQ(set_key(real_key_in(Interval::kNotNegative), ScalarValue(-0.0), s), "");
  EXPECT_FALSE(std::signbit(s.study.confidence));
  const ScenarioKey rows = key_of(RowsField{"made.up"});
  ASSERT_EQ(set_key(rows, NestedArray{{ScalarValue(-0.0), ScalarValue(std::int64_t{2})}}, s), "");
  EXPECT_FALSE(std::signbit(std::get<NumberRows>(s.own.at("made.up"))[0][0]));
  EXPECT_EQ(std::get<NumberRows>(s.own.at("made.up"))[0][1], 2.0);
}

TEST(ScenarioSchema, ArraysAreRefusedNamingTheirElement) {
  Scenario s;
  const ScenarioKey names = key_of(NamesField{"made.up"}), rows = key_of(RowsField{"made.up"});
  EXPECT_THAT(set_key(names, SchemaNames{}, s), StartsWith("must be an array of different names, not"));
  EXPECT_THAT(set_key(names, SchemaNames{std::string("a"), std::string()}, s),
              HasSubstr("element 2 is \"\""));
  EXPECT_THAT(set_key(names, SchemaNames{std::int64_t{3}}, s), HasSubstr("element 1 is 3"));
  EXPECT_THAT(set_key(rows, NestedArray{{ScalarValue(1.0)}, {ScalarValue(2.0), ScalarValue(true)}}, s),
              HasSubstr("row 2, column 2 is true"));
  EXPECT_TRUE(s.own.empty());
}

TEST(ScenarioSchema, ACopyOfAKeyThatIsNotGivenTakesItAway) {
  const ScenarioKey& F = known_key("world", "F");
  Scenario given = starting_scenario("linear"), other = given;
  ASSERT_EQ(set_key(F, NestedArray{{ScalarValue(1.0)}}, given), "");
  EXPECT_TRUE(F.in_effect_in(given));
  EXPECT_FALSE(F.in_effect_in(other)) << "an array that is not given";
  copy_key(F, given, other);
  EXPECT_EQ(other, given);
  copy_key(F, starting_scenario("linear"), other);
  EXPECT_EQ(key_value(F, other), SettingValue(SchemaNames{}));
  given.study.runs = 77;
  copy_key(known_key("study", "runs"), given, other);
  EXPECT_EQ(other.study.runs, 77);
}

// The rank of an inflation plays a part only with filter.inflation = "rank".
TEST(ScenarioSchema, AKeyIsAcceptedWhereItsWorldAndItsSwitchesAre) {
  const ScenarioKey& rank = known_key("filter", "inflation_rank");
  Scenario s = starting_scenario("monobot");
  EXPECT_FALSE(rank.accepted_in(s));
  s.filter.inflation = FilterInflation::rank;
  EXPECT_TRUE(rank.accepted_in(s));
  EXPECT_TRUE(rank.in_effect_in(s));
  s.world.model = "linear";
  EXPECT_FALSE(rank.accepted_in(s));
  EXPECT_FALSE(rank.in_effect_in(s));
  s.world.model = "nothing";
  EXPECT_FALSE(known_key("study", "runs").accepted_in(s)) << "a world that is none has no keys";
  EXPECT_EQ(known_key("study", "runs").accepted_where(), "") << "all worlds have it";
}

TEST(ScenarioSchema, KeysOfASectionStandTogetherAndThoseOfAllWorldsLast) {
  const std::vector<std::string_view> sections = scenario_sections();
  EXPECT_EQ(std::set<std::string_view>(sections.begin(), sections.end()).size(), sections.size());
  EXPECT_EQ(sections.front(), "world");
  EXPECT_EQ(sections.back(), "study.stop");
  EXPECT_EQ(scenario_keys().front().path(), "world.model");
  EXPECT_TRUE(scenario_keys().front().required());
  for (const std::string_view common : {"seed", "confidence"}) {
    EXPECT_EQ(known_key("study", common).uses.size(), world_schemas().size());
  }
  EXPECT_EQ(find_scenario_key("world", "seed"), nullptr) << "of another section";
}

}  // namespace
}  // namespace credence::internal
