#include "montecarlo/scenario/sweep_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan_values.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<double> numbers(std::string_view list) {
  std::vector<double> result;
  for (const ScalarValue& value : expand_sweep_list(list)) {
    const auto* integer = std::get_if<std::int64_t>(&value);
    result.push_back(integer != nullptr ? static_cast<double>(*integer) : std::get<double>(value));
  }
  return result;
}

std::string refusal(std::string_view list) {
  try {
    expand_sweep_list(list);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

SweepPlan plan(const std::string& sweep, const std::vector<std::string>& overrides = {},
               const std::string& base = "[world]\nmodel = \"monobot\"\n") {
  return plan_sweep(read_scenario_text(base + "[sweep]\n" + sweep, "s.toml", overrides));
}

std::string plan_error(const std::string& sweep, const std::vector<std::string>& overrides = {}) {
  return scenario_refusal([&] { plan(sweep, overrides); });
}

std::vector<std::string> ids(const SweepPlan& sweep) {
  std::vector<std::string> result;
  for (const SweepPoint& point : sweep.points) result.push_back(point.id);
  return result;
}

TEST(SweepPlan, SaysThatThereAreTooManyPointsBeforeAllListsAreMade) {
  std::string sweep;
  for (const char* key : {"process_variance", "measurement_variance", "initial_variance"})
    sweep += std::string("noise.") + key + " = \"lin(1, 2, 1000000)\"\n";
  EXPECT_THAT(plan_error(sweep), HasSubstr("1000000000000 points or more"));  // of two of the three
}

TEST(SweepList, ReadsNumbersWordsAndRanges) {
  EXPECT_THAT(numbers("3"), ElementsAre(3));
  EXPECT_THAT(numbers(" 1, 2.5 ,-4e1, +7"), ElementsAre(1, 2.5, -40, 7));
  EXPECT_THAT(numbers("1:4"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(numbers("1:3:12"), ElementsAre(1, 4, 7, 10));
  EXPECT_THAT(numbers("5:-2:1"), ElementsAre(5, 3, 1));
  EXPECT_THAT(numbers("-1:1"), ElementsAre(-1, 0, 1));
  EXPECT_THAT(numbers("1:2, 8, 10:10"), ElementsAre(1, 2, 8, 10));
  EXPECT_EQ(expand_sweep_list("none, with-vehicle"),
            (std::vector<ScalarValue>{std::string("none"), std::string("with-vehicle")}));
  EXPECT_EQ(expand_sweep_list("1:2"), (std::vector<ScalarValue>{std::int64_t{1}, std::int64_t{2}}));
}

// Adding 0.1 in binary would give 0.30000000000000004.
TEST(SweepList, DecimalRangesAreExact) {
  EXPECT_THAT(numbers("0.1:0.1:0.5"), ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
  const std::vector<double> fine = numbers("0:1e-3:2");
  ASSERT_EQ(fine.size(), 2001U);
  for (int i = 0; i <= 2000; ++i) {
    EXPECT_EQ(fine[static_cast<std::size_t>(i)], std::stod(std::to_string(i) + "e-3"));
  }
  EXPECT_THAT(numbers("1.5e3:5e2:2.5e3"), ElementsAre(1500, 2000, 2500));
}

TEST(SweepList, LinearAndLogarithmicSpacing) {
  EXPECT_THAT(numbers("lin(0,1,5)"), ElementsAre(0, 0.25, 0.5, 0.75, 1));
  EXPECT_THAT(numbers("lin(0.1, 0.5, 5)"), ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
  EXPECT_THAT(numbers("lin(1,0,11)"), ElementsAre(1, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0));
  EXPECT_THAT(numbers("log(0.01,100,5)"), ElementsAre(0.01, 0.1, 1, 10, 100));
  EXPECT_THAT(numbers("log(10,0.1,3)"), ElementsAre(10, 1, 0.1));
  const std::vector<double> nine = numbers("log(0.1,10,9)");
  ASSERT_EQ(nine.size(), 9U);
  EXPECT_EQ(nine.front(), 0.1);
  EXPECT_EQ(nine[4], 1.0);
  EXPECT_EQ(nine.back(), 10.0);
  EXPECT_EQ(nine[1], 0.177827941004);  // 10^-0.75 to 12 digits
  EXPECT_EQ(expand_sweep_list("log(1,1000,4)")[2], ScalarValue{std::int64_t{100}})
      << "whole numbers stay whole";
  EXPECT_EQ(expand_sweep_list("lin(1,9,3)")[1], ScalarValue{std::int64_t{5}});
  EXPECT_THAT(numbers("0.5, log(1,4,3), 8"), ElementsAre(0.5, 1, 2, 4, 8)) << "commas inside parentheses";
}

TEST(SweepList, RefusesNamingTheItem) {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"", "empty item"},
      {"1,,2", "empty item"},
      {"1,", "empty item"},
      {"5:1", "\"5:1\": the range, first:step:last, is empty"},
      {"1:5:2", "\"1:5:2\": the range, first:step:last, holds its first value alone"},
      {"1:0:5", "step"},
      {"1:-1:5", "empty"},
      {"1:2:3:4", "first:step:last"},
      {"1:", "no number"},
      {":", "no number"},
      {"a:b", "\"a\" is no number"},
      {"1.2.3:4", "no number"},
      {"nan:1", "no number"},
      {"0:1e-9:1", "more than 1000000 values"},
      {"0:1e-20:1", "exponent"},
      {"1:99999999999999999999", "digits"},
      {"log(0,1,3)", "must be > 0"},
      {"log(-1,1,3)", "must be > 0"},
      {"log(1,2)", "log(first, last, count)"},
      {"log(1,2,1)", "count"},
      {"log(1,2,3.5)", "count"},
      {"lin(1,2,9999999999)", "count"},
      {"lin(1,2,3", "accepted are lin"},
      {"exp(1,2,3)", "accepted are lin"},
      {"0:999999, 0:999999", "more than 1000000 values"},
  };
  for (const auto& [list, said] : cases) EXPECT_THAT(refusal(list), HasSubstr(said)) << list;
}

TEST(SweepPlan, GridCombinesAllValues) {
  const SweepPlan sweep = plan("\"world.landmarks\" = \"1:3\"\nfilter.inflation = \"none, full\"\n");
  ASSERT_EQ(sweep.points.size(), 6U);
  EXPECT_EQ(sweep.axes[0].path, "world.landmarks");
  EXPECT_EQ(sweep.axes[1].path, "filter.inflation");
  EXPECT_EQ(sweep.points[1].scenario.world.landmarks, 1);
  EXPECT_EQ(sweep.points[1].scenario.filter.inflation, FilterInflation::full);
  EXPECT_EQ(sweep.points[5].scenario.world.landmarks, 3);
  EXPECT_EQ(point_text(sweep, sweep.points[5]), "world.landmarks = 3, filter.inflation = \"full\"");
  for (const SweepPoint& point : sweep.points) {
    EXPECT_EQ(point.id, configuration_id(point.scenario));
    EXPECT_EQ(point.scenario.name, "s");
  }
}

TEST(SweepPlan, ZipPairsTheValuesInAnyOrder) {
  const SweepPlan sweep =
      plan("mode = \"zip\"\nworld.landmarks = [3, 1, 2]\nnoise.process_variance = \"0.3, 0.1, 0.2\"\n");
  ASSERT_EQ(sweep.points.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(sweep.points[i].scenario.world.landmarks, static_cast<Index>(i + 1));
    EXPECT_EQ(sweep.points[i].scenario.noise.process_variance, std::stod("0." + std::to_string(i + 1)));
  }
  const SweepPlan other =
      plan("noise.process_variance = [0.1, 0.2, 0.3]\nworld.landmarks = \"1:3\"\nmode = \"zip\"\n");
  EXPECT_EQ(ids(sweep), ids(other));
  EXPECT_EQ(canonical_toml(sweep), canonical_toml(other));
}

TEST(SweepPlan, IsTheSameForPointsInAnotherOrder) {
  const SweepPlan sweep = plan(
      "world.landmarks = \"1:3\"\nfilter.inflation = \"none, full, map\"\n"
      "noise.process_variance = [0.5, 1]\n");
  const SweepPlan other = plan(
      "noise.process_variance = \"1.0, 0.5\"\nfilter.inflation = [\"map\", \"none\", \"full\"]\n"
      "[sweep.world]\nlandmarks = \"3, 1:2, 2\"\n");
  EXPECT_EQ(sweep.points.size(), 18U);
  EXPECT_EQ(ids(sweep), ids(other));
  EXPECT_EQ(canonical_toml(sweep), canonical_toml(other));
  const SweepPlan from_options =
      plan("", {"sweep.filter.inflation=map,none,full", "sweep.world.landmarks=3,2,1",
                "sweep.noise.process_variance=[0.5, 1.0]"});
  EXPECT_EQ(ids(sweep), ids(from_options));
}

TEST(SweepPlan, OverridesReplaceAxesAndSettings) {
  const SweepPlan sweep =
      plan("world.landmarks = \"1:3\"\n", {"sweep.world.landmarks=10:10:50", "study.runs=7"});
  ASSERT_EQ(sweep.points.size(), 5U) << "10:10:50 is a range, no time of day";
  EXPECT_EQ(sweep.points[4].scenario.world.landmarks, 50);
  EXPECT_EQ(sweep.points[4].scenario.study.runs, 7);
  EXPECT_EQ(plan("world.landmarks = \"1:3\"\nstudy.steps = \"1:3\"\n", {"sweep.mode=zip"}).points.size(), 3U);
}

TEST(SweepPlan, MergesPointsThatAreTheSameConfiguration) {
  const SweepPlan sweep =
      plan("filter.inflation = \"none, map\"\nfilter.solution = \"pairwise, min-trace\"\n");
  EXPECT_EQ(sweep.points.size(), 3U) << "without inflation the solution plays no part";
  const std::vector<std::string> all = ids(sweep);
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size());
}

TEST(SweepPlan, LeavesOutImpossiblePointsWhenAskedTo) {
  const std::string map_of_ranks =
      "world.landmarks = \"1:4\"\nfilter.inflation_rank = \"0:5\"\nfilter.inflation = \"rank\"\n";
  const std::string said = plan_error(map_of_ranks);
  EXPECT_THAT(said, HasSubstr("s.toml:5: [sweep] filter.inflation_rank = \"0:5\", value 3"));
  EXPECT_THAT(said, HasSubstr("from 0 to 2 with world.landmarks = 1"));
  EXPECT_THAT(
      said,
      HasSubstr("sweep point world.landmarks = 1, filter.inflation = \"rank\", filter.inflation_rank = 3"));
  EXPECT_THAT(said, HasSubstr("skip_impossible"));
  const SweepPlan sweep = plan(map_of_ranks + "skip_impossible = true\n");
  EXPECT_EQ(sweep.points.size(), 3U + 4U + 5U + 6U);
  EXPECT_EQ(sweep.skipped, 24U - 18U);
  EXPECT_EQ(ids(sweep), ids(plan(map_of_ranks, {"sweep.skip_impossible=true"})));
}

TEST(SweepPlan, WithoutATableIsTheOneConfiguration) {
  const ScenarioDocument document = read_scenario_text("[world]\nmodel = \"planar\"\n", "one.toml");
  const SweepPlan sweep = plan_sweep(document);
  ASSERT_EQ(sweep.points.size(), 1U);
  EXPECT_TRUE(sweep.axes.empty());
  EXPECT_EQ(canonical_toml(sweep), canonical_toml(sweep.points[0].scenario));
}

TEST(SweepPlan, CanonicalTextPlansTheSamePoints) {
  for (const char* text :
       {"world.landmarks = \"1:3\"\n", "world.observability = \"partial, full\"\nstudy.seed = \"1:2\"\n",
        "filter.inflation = \"none, full, map\"\nfilter.solution = \"pairwise, min-trace\"\n",
        "mode = \"zip\"\nworld.landmarks = \"5, 2\"\nstudy.steps = \"10, 20\"\n",
        "skip_impossible = true\nfilter.inflation = \"full, map\"\nfilter.solution = \"sequential\"\n"}) {
    const SweepPlan sweep = plan(text, {"world.anchors=2"});
    const SweepPlan again = plan_sweep(read_scenario_text(canonical_toml(sweep), "s.toml"));
    EXPECT_EQ(ids(again), ids(sweep)) << canonical_toml(sweep);
    EXPECT_EQ(canonical_toml(again), canonical_toml(sweep));
  }
}

TEST(SweepPlan, RefusesNamingPlaceAndKey) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"world.landmark = \"1:3\"", {"s.toml:4: [sweep] world.landmark", "did you mean landmarks?"}},
      {"wrld.landmarks = \"1:3\"", {"s.toml:4: [sweep] wrld.landmarks", "did you mean [world]?"}},
      {"landmarks = \"1:3\"", {"s.toml:4: [sweep] landmarks", "world.landmarks"}},
      {"world.landmarks = \"3:1\"", {"s.toml:4: [sweep] world.landmarks = \"3:1\"", "empty"}},
      {"world.landmarks = []", {"s.toml:4: [sweep] world.landmarks = []", "at least one value"}},
      {"world.landmarks = \"\"", {"s.toml:4: [sweep] world.landmarks", "empty item"}},
      {"world.landmarks = \"1, 2.5\"",
       {"s.toml:4: [sweep] world.landmarks", "value 2.5", "an integer from 0"}},
      {"world.landmarks = [1, [2]]", {"s.toml:4: [sweep] world.landmarks", "an array"}},
      {"world.landmarks = 10:10:50", {"s.toml:4: ", "a date or time"}},
      {"world.landmarks = \"0:2\"", {"s.toml:4: ", "value 0", ">= 1", "sweep point world.landmarks = 0"}},
      {"noise.process_variance = \"lin(-1,1,3)\"", {"s.toml:4: ", "value -1", "finite number >= 0"}},
      {"noise.process_variance = [0.1, nan]", {"s.toml:4: ", "value nan", "finite number >= 0"}},
      {"filter.inflation = \"none, all\"",
       {"s.toml:4: ", "value \"all\"", "\"none\", \"full\", \"map\", \"rank\""}},
      {"noise.speed_std = \"1:2\"", {"s.toml:4: ", "value 1", "only with world.model = \"planar\""}},
      {"study.runs = \"100, 200\"", {"s.toml:4: ", "cannot be swept"}},
      {"study.confidence = [0.9, 0.95]", {"s.toml:4: ", "cannot be swept"}},
      {"mode = \"product\"", {"s.toml:4: [sweep] mode = \"product\"", "\"grid\", \"zip\""}},
      {"skip_impossible = 1", {"s.toml:4: [sweep] skip_impossible = 1", "true or false"}},
      {"world.landmarks = \"1:3\"\n\"world.landmarks\" = \"1:3\"", {"s.toml", "world.landmarks"}},
      {"mode = \"zip\"\nworld.landmarks = \"1:3\"\nstudy.steps = \"1:2\"",
       {"s.toml:6: ", "study.steps", "has 2 values", "world.landmarks has 3", "one length"}},
      {"world.landmarks = \"1:2000\"\nstudy.steps = \"1:2000\"",
       {"s.toml: [sweep] has 4000000 points", "1000000"}},
      {"skip_impossible = true\nworld.landmarks = 0", {"s.toml: [sweep] has no possible point"}},
  };
  for (const auto& [text, parts] : cases) {
    const std::string said = plan_error(text + "\n");
    for (const std::string& part : parts) EXPECT_THAT(said, HasSubstr(part)) << text;
  }
  EXPECT_THAT(plan_error("", {"sweep.world.landmarks=3:1"}), HasSubstr("--set sweep.world.landmarks=3:1: "));
  EXPECT_THAT(plan_error("", {"sweep.landmarks=3:1"}), HasSubstr("--set sweep.landmarks=3:1: "));
}

TEST(SweepPlan, AnOverrideOfWhatIsVariedIsRefused) {
  EXPECT_EQ(plan_error("\"world.landmarks\" = [1, 2]\n", {"world.landmarks=3"}),
            "--set world.landmarks=3: the sweep varies this key (s.toml:4: [sweep] world.landmarks = [1, "
            "2]); --set "
            "sweep.world.landmarks=... says over what");
  EXPECT_EQ(plan_error("\"world.landmarks\" = [1, 2]\n", {"sweep.world.landmarks=3", "study.runs=7"}),
            "accepted");
  EXPECT_EQ(scenario_refusal([] {  // of one configuration nothing is varied
              const std::vector<std::string> overrides = {"world.landmarks=3"};
              load_scenario_text("[world]\nmodel = \"monobot\"\n[sweep]\nworld.landmarks = [1, 2]\n",
                                 "s.toml", overrides);
            }),
            "accepted");
}

}  // namespace
}  // namespace credence::internal
