#include "montecarlo/scenario/key_fields.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace credence::internal {
namespace {

TEST(OwnFields, a_value_that_is_its_default_is_not_kept) {
  Scenario s;
  const RealField real = own_real("made.real", 0.5, Interval::kPositive);
  const IntegerField whole = own_integer("made.whole", 3, 1, 9);
  const ChoiceField word = own_choice("made.word", {"first", "second"});
  EXPECT_EQ(real.get(s), 0.5);
  EXPECT_EQ(whole.get(s), 3);
  EXPECT_EQ(word.get(s), 0U);
  real.set(s, 0.75);
  whole.set(s, 4);
  word.set(s, 1);
  EXPECT_EQ(s.own.size(), 3U);
  EXPECT_EQ(real.get(s), 0.75);
  EXPECT_EQ(whole.get(s), 4);
  EXPECT_EQ(word.get(s), 1U);
  EXPECT_NE(s, Scenario());
  real.set(s, 0.5);
  whole.set(s, 3);
  word.set(s, 0);
  EXPECT_EQ(s, Scenario()) << "a default that is written is that of one who is silent";
}

TEST(OwnFields, hold_the_bounds_that_they_were_given) {
  const IntegerField whole = own_integer("made.whole", 3, -2, 9);
  EXPECT_EQ(whole.low, -2);
  EXPECT_EQ(whole.high, 9);
  EXPECT_TRUE(own_real("made.real", 1.0, Interval::kPositive).accepted.low_open);
  EXPECT_EQ(own_choice("made.word", {"first", "second"}).words.size(), 2U);
}

TEST(MemberFields, reach_their_member) {
  Scenario s;
  const RealField real = real_field<&Scenario::noise, &NoiseSettings::range_std>(Interval::kPositive);
  real.set(s, 0.7);
  EXPECT_EQ(s.noise.range_std, 0.7);
  EXPECT_EQ(real.get(s), 0.7);
  const IntegerField seed = integer_field<&Scenario::study, &StudySettings::seed>(0, 100);
  seed.set(s, 42);
  EXPECT_EQ(s.study.seed, 42U);
  const ChoiceField stop = choice_field<&Scenario::stop, &StopSettings::verdict>(StopVerdict::either);
  ASSERT_EQ(stop.words.size(), 3U);
  stop.set(s, 2);
  EXPECT_EQ(s.stop.verdict, StopVerdict::either);
  EXPECT_EQ(stop.words[stop.get(s)], to_string(StopVerdict::either));
}

TEST(KeyValues, are_found_by_their_path) {
  Scenario s;
  s.noise.range_std = 0.7;
  s.study.steps = 12;
  s.stop.max_runs = 5;
  s.filter.inflation = FilterInflation::map;
  EXPECT_EQ(real_value(s, "noise.range_std"), 0.7);
  EXPECT_EQ(integer_value(s, "study.steps"), 12);
  EXPECT_EQ(integer_value(s, "study.stop.max_runs"), 5) << "the section has a dot of its own";
  EXPECT_EQ(word_value(s, "filter.inflation"), "map");
  EXPECT_EQ(integer_value(s, "world.dimensions"), 2) << "the default of a world's own key";
}

TEST(KeyValues, of_no_key_or_another_type_are_refused) {
  const Scenario s;
  for (const char* path : {"noise.nothing", "range_std", "", ".", "noise.", "study.steps"}) {
    EXPECT_THROW(real_value(s, path), std::invalid_argument) << path;
  }
  EXPECT_THROW(integer_value(s, "noise.range_std"), std::invalid_argument);
  EXPECT_THROW(word_value(s, "study.steps"), std::invalid_argument);
}

TEST(KeyValues, of_an_array_that_is_not_given_are_none) {
  Scenario s;
  EXPECT_TRUE(rows_value(s, "world.F").empty());
  EXPECT_TRUE(names_value(s, "world.states").empty());
  s.own["world.F"] = NumberRows{{1.0, 2.0}};
  s.own["world.states"] = std::vector<std::string>{"a"};
  EXPECT_EQ(rows_value(s, "world.F"), (NumberRows{{1.0, 2.0}}));
  EXPECT_EQ(names_value(s, "world.states"), std::vector<std::string>{"a"});
}

}  // namespace
}  // namespace credence::internal
