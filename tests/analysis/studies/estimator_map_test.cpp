#include "analysis/studies/estimator_map.h"

#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>

#include "montecarlo/engine/shared_tasks.h"
#include "montecarlo/scenario/scenario_io.h"
#include "tests/montecarlo/engine/thread_ranks.h"

namespace credence::internal {
namespace {

constexpr const char* kSweep =
    "[world]\nmodel = \"planar_slam\"\nlandmark_layout = \"annulus\"\nlandmarks = 20\ndt = 1.0\n"
    "[study]\nruns = 80\nsteps = 600\n[sweep]\nnoise.turn_rate_std = [0.001, 0.02]\n";

// Where the heading is nearly known the EKF will do; where it is not, a dearer filter is needed.
TEST(EstimatorMap, TheCheapestIsTheOneThatIsEnough) {
  const SweepPlan plan = plan_sweep(read_scenario_text(kSweep, "t.toml"));
  ASSERT_EQ(plan.points.size(), 2U);
  EstimatorMap map = map_estimators(plan, {.estimators = {"ideal", "ekf", "invariant"}});
  ASSERT_TRUE(map.complete);
  ASSERT_EQ(map.studies.size(), 2U);
  map.seconds_per_step = {1e-6, 2e-6, 3e-6};  // as measured, but the same on every machine
  EXPECT_TRUE(map.stays_consistent(0, 1));
  EXPECT_FALSE(map.stays_consistent(1, 1));
  EXPECT_EQ(map.cheapest(0), 1U);  // not the ideal filter, cheaper as it were
  EXPECT_EQ(map.cheapest(1), 2U);
  map.seconds_per_step = {1e-6, 2.2e-6, 2e-6};
  EXPECT_EQ(map.cheapest(0), 1U) << "the first of two that cost the same";
  map.studies[1].rows[2].failures.push_back({3, 7, Outcome::diverged});
  EXPECT_EQ(map.cheapest(1), std::nullopt);
}

/// A filter that claims a tenth of the variance, an exact one, and one that claims ten times as much.
SweepPlan three_scales() {
  return plan_sweep(read_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[0.9]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
      "[study]\nruns = 24\nsteps = 50\n[sweep]\nmode = \"zip\"\n"
      "filter.process_scale = [0.1, 1.0, 10.0]\nfilter.measurement_scale = [0.1, 1.0, 10.0]\n",
      "t.toml"));
}

TEST(EstimatorMap, BothDirectionsAreJudged) {
  EstimatorMap map = map_estimators(three_scales(), {.estimators = {"kalman"}});
  ASSERT_EQ(map.studies.size(), 3U);
  EXPECT_EQ(map.verdict(0, 0), Verdict::optimistic);
  EXPECT_EQ(map.verdict(1, 0), Verdict::consistent);
  EXPECT_EQ(map.verdict(2, 0), Verdict::pessimistic);
  EXPECT_EQ(map.cheapest(0), std::nullopt);
  EXPECT_EQ(map.cheapest(1), 0U);
  EXPECT_EQ(map.cheapest(2), std::nullopt);
  // What so few runs leave open is no recommendation.
  for (const auto& [lower, upper] : {std::pair(0.9, 2.1), {0.4, 1.1}}) {
    map.studies[1].rows[0].nees[static_cast<std::size_t>(EstimatorBlock::pose)] = {
        .mean = 1.0, .lower = lower, .upper = upper, .count = 24};
    EXPECT_EQ(map.verdict(1, 0), Verdict::undecided);
    EXPECT_EQ(map.cheapest(1), std::nullopt);
  }
}

TEST(EstimatorMap, AllRanksGoToEveryPoint) {
  const EstimatorMap alone = map_estimators(three_scales(), {.estimators = {"kalman"}});
  on_ranks(3, [&](ThreadRanks& ranks) {
    std::optional<EstimatorMap> map;
    try {
      map = map_estimators(three_scales(), {.estimators = {"kalman"}, .threads = 1, .ranks = &ranks});
    } catch (const RanksEnded&) {
    }
    finish_ranks(ranks);
    if (is_helper(&ranks)) {
      EXPECT_TRUE(!map || map->studies.size() == 3U);
      return;
    }
    ASSERT_TRUE(map.has_value());
    EXPECT_TRUE(map->complete);
    for (std::size_t point = 0; point < 3; ++point)
      EXPECT_EQ(map->studies[point].rows[0].nees[0].mean, alone.studies[point].rows[0].nees[0].mean);
  });
}

TEST(EstimatorMap, OtherWorldsAreRefused) {
  const SweepPlan plan =
      plan_sweep(read_scenario_text("[world]\nmodel = \"planar\"\n[sweep]\nworld.landmarks = [3, 4]\n", "t"));
  EXPECT_THROW(map_estimators(plan, {}), std::invalid_argument);
}

TEST(EstimatorMap, HasTheEstimatorsThatTakeEveryPoint) {
  const SweepPlan plan =
      plan_sweep(read_scenario_text("[world]\nmodel = \"linear\"\nF = [[0.9]]\nH = [[1]]\nQ = [[1]]\nR = "
                                    "[[1]]\nP0 = [[1]]\n[study]\nruns = 4\nsteps = 10\n[sweep]\n"
                                    "noise.detection_probability = [1.0, 0.8]\n",
                                    "t.toml"));
  const EstimatorMap map = map_estimators(plan, {});
  EXPECT_EQ(map.names, std::vector<std::string>{"kalman"});
  ASSERT_EQ(map.left_out.size(), 2U);
  EXPECT_EQ(map.left_out[0].name, "steady-state");
  EXPECT_EQ(map.left_out[1].name, "smoother");
}

}  // namespace
}  // namespace credence::internal
