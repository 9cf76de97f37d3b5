#include "analysis/tuning/tune_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

/// A position that wanders, seen in noise. The filter believes a fourth of Q, by its scale and by its matrix,
/// and has R right.
Scenario wanderer(const std::string& study = "") {
  return load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[0.04]]\nR = [[1]]\n"
      "P0 = [[1]]\nstates = [\"x\"]\n[filter]\nQ = [[0.02]]\nprocess_scale = 0.5\n"
      "[study]\nruns = 100\nsteps = 60\n" +
          study,
      "wanderer");
}

TEST(TuneScenario, ValuesAreThoseOfTheKeysOfTheScenario) {
  const auto t = tune_scenario(wanderer(), {});
  ASSERT_TRUE(t && t->tuning.anything_known());
  const TunedParameter &Q = t->tuning.parameters.at(0), &R = t->tuning.parameters.at(1);
  EXPECT_EQ(Q.name, "filter.process_scale");
  EXPECT_EQ(Q.before, 0.5);
  EXPECT_EQ(R.name, "filter.measurement_scale");
  EXPECT_EQ(R.before, 1.0);
  EXPECT_EQ(t->tuning.coordinates, (std::vector<std::string>{Q.name, R.name}));
  EXPECT_EQ(t->tuning.forecast.parameters.at(0).name, Q.name);
  // The scale that makes filter.Q the true one is 2; its logarithm has the standard error of the interval.
  for (const auto& [p, truth] : {std::pair{Q, 2.0}, std::pair{R, 1.0}}) {
    const double error = std::log(p.upper / p.lower) / (2.0 * 1.96);
    EXPECT_GT(error, 0.0) << p.name;
    EXPECT_LT(error, 0.2) << p.name;
    EXPECT_NEAR(std::log(p.value / truth), 0.0, 5.0 * error) << p.name;
    EXPECT_GT(p.bootstrap_upper, p.value) << p.name;
    EXPECT_LT(p.bootstrap_lower, p.value) << p.name;
  }
  EXPECT_NEAR(t->tuned.filter.process_scale, Q.value, 1e-12 * Q.value);
  EXPECT_NEAR(t->tuned.filter.measurement_scale, R.value, 1e-12 * R.value);
}

TEST(TuneScenario, TellsHowFarTheSearchAndBothStudiesAre) {
  TuneRequest request;
  request.threads = 1;
  std::vector<double> plays;
  std::vector<StudyProgress> fresh;
  request.watch = [&](double count) { plays.push_back(count); };
  request.progress = [&](const StudyProgress& progress) { fresh.push_back(progress); };
  ASSERT_TRUE(tune_scenario(wanderer(), request));
  ASSERT_FALSE(plays.empty());
  EXPECT_LT(plays.front(), 1.0) << "within the first play";
  EXPECT_TRUE(std::ranges::is_sorted(plays));
  ASSERT_FALSE(fresh.empty());
  EXPECT_EQ(fresh.front().runs_total, 200);
  EXPECT_EQ(fresh.back().runs_done, 200);
}

TEST(TuneScenario, IsJudgedByTheNoiseOfTheNextSeedBeforeAndAfter) {
  const auto t = tune_scenario(wanderer("seed = 7\n"), {});
  ASSERT_TRUE(t && t->held_out);
  EXPECT_EQ(t->held_out->before.scenario.study.seed, 8U);
  EXPECT_EQ(t->held_out->after.scenario.study.seed, 8U);
  EXPECT_EQ(t->held_out->before.statistics.runs, 100);
  EXPECT_EQ(t->held_out->before.nis.verdict, Verdict::optimistic);
  EXPECT_FALSE(is_inconsistent(t->held_out->after.word.verdict));
  EXPECT_LT(std::abs(t->held_out->after.nis.mean - 1.0), std::abs(t->held_out->before.nis.mean - 1.0));
  // 6000 innovations: the mean of their NIS has a standard error of √(2/6000), and 80 % power at 5 % takes
  // 1.96 + 0.84 of them.
  const double error = std::sqrt(2.0 / 6000.0);
  EXPECT_NEAR(t->held_out->detectable.above, 1.0 + 2.8 * error, 0.5 * error);
  EXPECT_NEAR(t->held_out->detectable.below, 1.0 - 2.8 * error, 0.5 * error);
}

TEST(TuneScenario, TheSeedAfterTheLargestIsTheFirst) {
  Scenario scenario = wanderer();
  scenario.study.runs = 20;
  scenario.study.seed = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto t = tune_scenario(scenario, {});
  ASSERT_TRUE(t && t->held_out);
  EXPECT_EQ(t->held_out->after.scenario.study.seed, 0U);
}

TEST(TuneScenario, OnTheRidgeTheMeanNisIsThatOfTheTunedFilter) {
  const auto t = tune_scenario(wanderer(), {});
  ASSERT_TRUE(t && t->ridge_of);
  EXPECT_EQ(*t->ridge_of, (std::pair<Index, Index>{0, 1}));
  ASSERT_FALSE(t->ridge.empty());
  const auto mean_nis = [&](const Vector& phi) {
    const UnitScores scores = t->score->model().scores(phi, false);
    return scores.nis.sum() / scores.steps;
  };
  for (const RidgePoint& point : t->ridge) {
    EXPECT_NEAR(mean_nis(point.phi), 1.0, 1e-3);
    EXPECT_GT(point.drop, 0.0) << "the tuned noise is the maximum";
  }
}

TEST(TuneScenario, WhoStopsItGetsNothing) {
  const std::atomic<bool> stop = true;
  TuneRequest request;
  request.stop = &stop;
  EXPECT_FALSE(tune_scenario(wanderer(), request));
}

/// An extended Kalman filter with wrong noise: the tuned one is near the truth and named by its keys.
TEST(TuneScenario, TunesANonlinearFilter) {
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"planar\"\nlandmarks = 4\nanchors = 2\nobservability = \"full\"\n"
      "[filter]\nprocess_scale = 4.0\nmeasurement_scale = 0.5\n[study]\nruns = 12\nsteps = 60\n",
      "planar");
  const auto tuning = tune_scenario(scenario, {});
  ASSERT_TRUE(tuning);
  const auto& parameters = tuning->tuning.parameters;
  EXPECT_EQ(parameters[0].name, "filter.process_scale");
  EXPECT_EQ(parameters[0].before, 4.0);
  for (const TunedParameter& p : parameters) {
    const double deviation = std::log(p.upper / p.lower) / (2.0 * 1.96);
    EXPECT_LT(deviation, 0.3) << p.name;
    EXPECT_NEAR(std::log(p.value), 0.0, 5.0 * deviation) << p.name << " = " << p.value;
  }
  EXPECT_EQ(tuning->tuned.filter.process_scale, parameters[0].value);
  ASSERT_TRUE(tuning->held_out);
  EXPECT_NE(tuning->held_out->after.scenario.study.seed, scenario.study.seed);
  // Of its innovations the range is too large for S, and with so much noise of the turn the bearing too
  // small.
  EXPECT_EQ(tuning->held_out->before.word.verdict, Verdict::mixed);
  EXPECT_THAT(tuning->held_out->before.word.says,
              ::testing::HasSubstr("pessimistic in component 2 of the innovation"));
}

TEST(TuneScenario, RefusesWhatTheFilterHasNotOfItsOwn) {
  const Scenario scenario = load_scenario_text("[world]\nmodel = \"tracking\"\n", "tracking");
  TuneRequest request;
  for (const char* free : {"P0", "diag(Q)", "full(R)"}) {
    request.free = parse_free_noise(free);
    EXPECT_THROW(tune_scenario(scenario, request), std::invalid_argument) << free;
  }
}

}  // namespace
}  // namespace credence::internal
