#include "montecarlo/scenario/sweep_plan_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/sweep_plan_values.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Setting swept(const char* section, const char* key, SettingValue value) {
  return {section, key, std::move(value), "s.toml:4: [sweep] it"};
}

Axis axis_of(const char* section, const char* key, SettingValue value) {
  return make_axis(swept(section, key, std::move(value)), {});
}

std::vector<ScalarValue> values_of_axis(const Axis& axis) {
  std::vector<ScalarValue> values;
  for (const AxisValue& value : axis.values) values.push_back(value.value());
  return values;
}

std::vector<ScalarValue> whole(std::initializer_list<std::int64_t> list) {
  return {list.begin(), list.end()};
}

TEST(SweepAxis, a_scalar_a_list_and_a_text_are_lists) {
  EXPECT_EQ(values_of_axis(axis_of("world", "landmarks", ScalarValue(std::int64_t{3}))), whole({3}));
  EXPECT_EQ(values_of_axis(axis_of("world", "landmarks", ScalarValue(std::string("3, 1:2")))),
            whole({3, 1, 2}));
  EXPECT_EQ(values_of_axis(
                axis_of("world", "landmarks", std::vector<ScalarValue>{std::int64_t{5}, std::string("1:2")})),
            whole({5, 1, 2}));
}

TEST(SweepAxis, is_sorted_by_number_or_by_the_order_of_the_words_each_once) {
  Axis numbers = axis_of("noise", "process_variance", ScalarValue(std::string("2, 10, 1e-3, 2.0, 1")));
  sort_values(numbers);
  EXPECT_THAT(values_of_axis(numbers),
              ElementsAre(ScalarValue(1e-3), ScalarValue(1.0), ScalarValue(2.0), ScalarValue(10.0)));
  Axis words = axis_of("filter", "inflation", ScalarValue(std::string("rank, map, none, map")));
  sort_values(words);
  EXPECT_THAT(values_of_axis(words),
              ElementsAre(ScalarValue(std::string("none")), ScalarValue(std::string("map")),
                          ScalarValue(std::string("rank"))));
}

// Doubles would take the last two for one.
TEST(SweepAxis, seeds_keep_all_their_bits) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  Axis seeds = axis_of("study", "seed", std::vector<ScalarValue>{kMost, std::int64_t{0}, kMost - 1});
  sort_values(seeds);
  EXPECT_EQ(values_of_axis(seeds), whole({0, kMost - 1, kMost}));
}

TEST(SweepAxis, values_are_refused_by_their_key_with_their_place) {
  const auto refusal = [](const char* section, const char* key, SettingValue value) {
    try {
      axis_of(section, key, std::move(value));
    } catch (const ScenarioError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("world", "landmarks", ScalarValue(std::string("1, -2"))),
              HasSubstr("s.toml:4: [sweep] it, value -2: must be an integer from 0"));
  EXPECT_THAT(refusal("noise", "process_variance", ScalarValue(std::numeric_limits<double>::infinity())),
              HasSubstr("value inf: must be a finite number >= 0"));
  EXPECT_THAT(refusal("world", "F", std::vector<ScalarValue>{1.0}), HasSubstr("since it is an array"));
  EXPECT_THAT(refusal("world", "states", std::vector<ScalarValue>{std::string("a")}),
              HasSubstr("since it is an array"));
  EXPECT_THAT(refusal("world", "landmarks", NestedArray{{std::int64_t{1}}}), HasSubstr("not an array"));
  for (const char* stop : {"verdict", "max_runs", "precision"}) {
    EXPECT_THAT(refusal("study.stop", stop, ScalarValue(std::int64_t{1})), HasSubstr("cannot be swept"))
        << stop;
  }
}

TEST(SweepPoints, of_a_grid_have_the_last_axis_fastest) {
  const std::vector<Axis> axes = {axis_of("world", "landmarks", ScalarValue(std::string("1:2"))),
                                  axis_of("study", "steps", ScalarValue(std::string("5:7")))};
  EXPECT_THAT(grid_points(axes), ElementsAre(AxisIndices{0, 0}, AxisIndices{0, 1}, AxisIndices{0, 2},
                                             AxisIndices{1, 0}, AxisIndices{1, 1}, AxisIndices{1, 2}));
  EXPECT_THAT(grid_points({}), ElementsAre(AxisIndices{}));
}

TEST(SweepPoints, of_a_zip_are_in_the_order_of_their_values) {
  const std::vector<Axis> axes = {axis_of("world", "landmarks", ScalarValue(std::string("3, 1, 3, 2"))),
                                  axis_of("study", "steps", ScalarValue(std::string("9, 8, 7, 6")))};
  EXPECT_THAT(zip_points(axes),
              ElementsAre(AxisIndices{1, 1}, AxisIndices{3, 3}, AxisIndices{2, 2}, AxisIndices{0, 0}));
  EXPECT_THAT(zip_points({}), ElementsAre(AxisIndices{}));
}

TEST(SweepPoints, are_counted_to_the_last_one_that_is_accepted) {
  EXPECT_NO_THROW(check_count(static_cast<double>(kLargestSweep), "s.toml"));
  EXPECT_THROW(check_count(static_cast<double>(kLargestSweep) + 1.0, "s.toml"), ScenarioError);
  EXPECT_THROW(check_count(1e300, "s.toml"), ScenarioError);
}

}  // namespace
}  // namespace credence::internal
