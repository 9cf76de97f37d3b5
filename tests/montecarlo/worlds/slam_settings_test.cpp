#include "montecarlo/worlds/slam_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_resolve.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario monobot_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"monobot\"\n", "t.toml", overrides);
}

std::string refused_settings(const std::vector<std::string>& overrides) {
  try {
    monobot_scenario(overrides);
  } catch (const ImpossibleCombination& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SlamSettings, AWorldNeedsSomethingToSee) {
  EXPECT_THAT(refused_settings({"world.landmarks=0"}),
              HasSubstr("landmarks=0: must be >= 1 with world.observability = \"partial\""));
  EXPECT_THAT(refused_settings({"world.landmarks=0", "world.observability=full", "world.anchors=0"}),
              HasSubstr("anchors=0: must be >= 1 with world.observability = \"full\""));
  EXPECT_EQ(refused_settings({"world.landmarks=0", "world.observability=full"}), "accepted");
}

TEST(SlamSettings, BoundsOfTheMapAloneAreRefusedForTheWholeState) {
  for (const char* solution : {"sequential", "batch", "drop"}) {
    const std::string of = std::string("filter.solution=") + solution;
    EXPECT_THAT(refused_settings({"filter.inflation=full", of}),
                HasSubstr("needs filter.inflation = \"map\""));
    EXPECT_EQ(refused_settings({"filter.inflation=map", of}), "accepted");
  }
  for (const char* solution : {"pairwise", "min-trace"}) {
    EXPECT_EQ(refused_settings({"filter.inflation=full", std::string("filter.solution=") + solution}),
              "accepted");
  }
}

TEST(SlamSettings, ARankIsOneThatItsRangeHas) {
  // Of 1 + 3 states: all of them, those of three landmarks, the vehicle's own noise at least, two
  // differences.
  const auto rank = [](int value, const char* range) {
    return refused_settings({"world.landmarks=3", "filter.inflation=rank",
                             "filter.inflation_rank=" + std::to_string(value),
                             std::string("filter.inflation_range=") + range});
  };
  struct Accepted {
    const char* range;
    int least, most;
  };
  for (const Accepted& a :
       {Accepted{"generic", 0, 4}, {"map", 0, 3}, {"with-vehicle", 1, 4}, {"difference", 0, 2}}) {
    EXPECT_EQ(rank(a.least, a.range), "accepted") << a.range;
    EXPECT_EQ(rank(a.most, a.range), "accepted") << a.range;
    EXPECT_THAT(rank(a.most + 1, a.range), HasSubstr("must be from " + std::to_string(a.least) + " to " +
                                                     std::to_string(a.most) + " with world.landmarks = 3"));
  }
  EXPECT_THAT(rank(0, "with-vehicle"), HasSubstr("must be from 1 to 4"));
}

TEST(SlamSettings, TheConstantHasItsRankAndItsEigenvalues) {
  const InflationRule rule = make_inflation_rule(
      monobot_scenario({"world.landmarks=3", "filter.inflation=rank", "filter.inflation_rank=2",
                        "filter.inflation_range=difference", "filter.inflation_scale=0.25"}));
  ASSERT_EQ(rule.constant.rows(), 4);
  EXPECT_EQ(rule.inflation, Inflation::none);
  const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(rule.constant).eigenvalues();
  EXPECT_LT((eigenvalues - Vector{{0.0, 0.0, 0.25, 0.25}}).cwiseAbs().maxCoeff(), 1e-14);
  // Differences of landmarks: neither the vehicle nor the sum of the landmarks is touched.
  EXPECT_LT(rule.constant.row(0).norm(), 1e-14);
  EXPECT_LT((rule.constant * Vector{{0.0, 1.0, 1.0, 1.0}}).norm(), 1e-14);
}

TEST(SlamSettings, TheRuleIsWhatTheFilterAsksFor) {
  EXPECT_EQ(make_inflation_rule(monobot_scenario({})).inflation, Inflation::none);
  const InflationRule full = make_inflation_rule(monobot_scenario({"filter.inflation=full"}));
  EXPECT_EQ(full.inflation, Inflation::full);
  EXPECT_EQ(full.constant.size(), 0);
  EXPECT_FALSE(full.is_sequential());
  const InflationRule map =
      make_inflation_rule(monobot_scenario({"filter.inflation=map", "filter.solution=batch"}));
  EXPECT_EQ(map.inflation, Inflation::map);
  EXPECT_TRUE(map.is_sequential());
}

TEST(SlamSettings, SayWhatTheWorldIs) {
  EXPECT_EQ(slam_text(monobot_scenario({})), "monobot, 2 landmarks, partially observable");
  EXPECT_EQ(slam_text(monobot_scenario({"world.landmarks=1", "world.observability=full"})),
            "monobot, 1 landmark, 1 anchor");
  EXPECT_EQ(slam_text(monobot_scenario(
                {"world.observability=full", "world.anchors=2", "noise.detection_probability=0.5"})),
            "monobot, 2 landmarks, 2 anchors, each measured with probability 0.5");
  EXPECT_EQ(slam_size_text(monobot_scenario({"world.landmarks=7"})),
            "world.landmarks = 7, world.anchors = 0");
}

}  // namespace
}  // namespace credence::internal
