#include "analysis/studies/estimator_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "core/filters/estimators/estimators.h"
#include "montecarlo/scenario/scenario_io.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

Scenario load(const char* name, const std::vector<std::string>& overrides = {}) {
  return load_scenario(source_folder() / "scenarios" / (std::string(name) + ".toml"), overrides);
}

const MeanInterval& nees(const EstimatorRow& row, EstimatorBlock block) {
  return row.nees[static_cast<std::size_t>(block)];
}

// Table A of docs/estimators.md with few runs. The ideal filter's NEES is 1 but for the curvature of the
// world, less than the 0.05 allowed beside five standard errors.
TEST(EstimatorStudy, TheBenchmarkHasItsNumbers) {
  const EstimatorStudy study = study_estimators(load("ukfm_slam2d", {"study.runs=64", "study.steps=1200"}),
                                                {.estimators = {"ideal", "fej", "oc", "invariant"}});
  ASSERT_EQ(study.rows.size(), 4U);
  for (const EstimatorRow& row : study.rows) {
    EXPECT_EQ(row.runs, 64) << row.name;
    EXPECT_EQ(row.unobservable, 3) << row.name;
    for (const EstimatorBlock block :
         {EstimatorBlock::heading, EstimatorBlock::position, EstimatorBlock::pose}) {
      const MeanInterval& n = nees(row, block);
      EXPECT_NEAR(n.mean, 1.0, 5 * n.standard_error + 0.05) << row.name;
      EXPECT_LE(n.lower, n.mean);
      EXPECT_GE(n.upper, n.mean);
    }
    // The bound is that of the ideal filter but for its curvature.
    EXPECT_NEAR(row.claimed_position_m, std::sqrt(study.bound.position_squared),
                0.05 * row.claimed_position_m);
    const MeanInterval& efficiency = row.position_efficiency;
    EXPECT_NEAR(efficiency.mean, 1.0, 5 * efficiency.standard_error + 0.05) << row.name;
    EXPECT_LT(efficiency.lower, efficiency.mean);
    EXPECT_GT(efficiency.upper, efficiency.mean);
    EXPECT_GT(row.profile.seconds_per_step, 0.0);
    ASSERT_EQ(row.pose_nees.size(), 100U);
    const Band& band = row.bands[0];
    EXPECT_TRUE(std::ranges::is_sorted(band));
  }
  EXPECT_EQ(study.window_ends.back(), 1200.0);
}

// What the choice of the chart does: sigma points of the right-invariant error are consistent, those of the
// left-invariant one, which takes the heading for known after every correction, are far from it.
TEST(EstimatorStudy, TheSideOfTheErrorMatters) {
  const EstimatorStudy study =
      study_estimators(load("ukfm_slam2d", {"study.runs=32", "study.steps=1500"}),
                       {.estimators = {"ukf-manifold", "ukf-manifold-left", "invariant-reset"}});
  const MeanInterval& right = nees(study.rows[0], EstimatorBlock::position);
  EXPECT_NEAR(right.mean, 1.0, 5 * right.standard_error + 0.05);
  for (const std::size_t i : {1U, 2U}) EXPECT_GT(nees(study.rows[i], EstimatorBlock::position).mean, 5.0);
}

// Table C (i): on a map drawn at random the EKF is far from consistent, the invariant filter is not.
TEST(EstimatorStudy, TheEkfIsFoundOptimistic) {
  const EstimatorStudy study =
      study_estimators(load("huang_annulus", {"study.runs=128"}), {.estimators = {"ekf", "invariant"}});
  const EstimatorRow &ekf = study.rows[0], &invariant = study.rows[1];
  EXPECT_EQ(ekf.unobservable, 2);
  EXPECT_EQ(invariant.unobservable, 3);
  const MeanInterval& n = nees(ekf, EstimatorBlock::heading);
  EXPECT_GT(n.mean - 5 * n.standard_error, 2.0);
  EXPECT_LT(nees(invariant, EstimatorBlock::heading).mean, 2.0);
  ASSERT_EQ(study.paired.size(), 2U);
  EXPECT_FALSE(study.paired[0].of_position);
  EXPECT_GT(study.paired[0].difference.lower, 1.0);
  EXPECT_LT(study.paired[0].p_value, 1e-5);
  EXPECT_TRUE(study.paired[1].of_position);
  EXPECT_GT(study.paired[1].difference.lower, 0.0);
}

// Table B of docs/estimators.md in small: in space the plain filters take the attitude for known, and are
// optimistic where noise is large; the invariant filter and the yardstick are not.
TEST(EstimatorStudy, InSpaceTheOrderIsThatOfThePlane) {
  const EstimatorStudy study =
      study_estimators(load("zhang_3d", {"study.runs=48", "study.steps=250", "world.landmarks=60",
                                         "noise.odometry_share=0.1", "noise.landmark_share=0.1"}),
                       {.estimators = {"ideal", "fej", "invariant", "ekf", "ekf-se3"}});
  ASSERT_EQ(study.rows.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    const EstimatorRow& row = study.rows[i];
    EXPECT_EQ(row.runs, 48) << row.name;
    EXPECT_EQ(row.unobservable, i < 3 ? 6 : 3) << row.name;
    EXPECT_GT(row.nees[static_cast<std::size_t>(EstimatorBlock::map)].count, 0) << row.name;
  }
  for (const std::size_t i : {0U, 2U}) {
    const MeanInterval& pose = nees(study.rows[i], EstimatorBlock::pose);
    EXPECT_NEAR(pose.mean, 1.0, 5 * pose.standard_error + 0.05) << study.rows[i].name;
    EXPECT_NEAR(study.rows[i].claimed_position_m, std::sqrt(study.bound.position_squared),
                0.1 * study.rows[i].claimed_position_m);
  }
  const auto excess = std::ranges::find_if(study.paired, [](const PairedDifference& p) {
    return p.first == "invariant" && p.second == "ekf" && !p.of_position;
  });
  ASSERT_NE(excess, study.paired.end());
  EXPECT_LT(excess->difference.mean + 5 * excess->difference.standard_error, 0.0);
}

// In a linear world all are consistent, by their own P; the smoother is the most accurate, the Kalman filter
// the best of the filters. What has no meaning there is left empty.
TEST(EstimatorStudy, ALinearWorldHasItsEstimators) {
  const EstimatorStudy study = study_estimators(load("linear_estimators", {"study.runs=400"}), {});
  std::vector<std::string> names;
  for (const EstimatorRow& row : study.rows) names.push_back(row.name);
  EXPECT_THAT(names, ::testing::ElementsAre("kalman", "steady-state", "smoother", "schmidt", "own-gain"));
  for (const EstimatorRow& row : study.rows) {
    const MeanInterval& state = nees(row, EstimatorBlock::pose);
    EXPECT_NEAR(state.mean, 1.0, 5 * state.standard_error) << row.name;
    EXPECT_EQ(nees(row, EstimatorBlock::map).count, 0);
    EXPECT_EQ(row.unobservable, 0);
    const double rmse = row.position_rmse_m.mean, kalman = study.rows[0].position_rmse_m.mean;
    if (row.name == "smoother") {
      EXPECT_LT(rmse, kalman);
    } else if (row.name != "kalman") {
      EXPECT_GT(rmse, kalman);
    }
  }
  // Without what they need schmidt and own-gain are not offered.
  const Scenario plain = load("linear", {"study.runs=5", "study.steps=5"});
  EXPECT_EQ(study_estimators(plain, {}).rows.size(), 3U);
  EXPECT_THROW(study_estimators(plain, {.estimators = {"own-gain"}}), std::invalid_argument);
}

// Runs end where the statistics of errors grow beyond all numbers: without and with missed measurements.
TEST(EstimatorStudy, ALinearFilterThatFailsIsNamed) {
  const char* text =
      "[world]\nmodel = \"linear\"\nF = [[2]]\nH = [[0]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
      "[study]\nruns = 5\nsteps = 1200\n";
  for (const char* detection : {"1", "0.9"}) {
    const std::vector<std::string> missed = {std::string("noise.detection_probability=") + detection};
    const EstimatorStudy study =
        study_estimators(load_scenario_text(text, "s.toml", missed), {.estimators = {"kalman"}});
    const EstimatorRow& row = study.rows.front();
    EXPECT_EQ(row.runs, 0) << detection;
    ASSERT_EQ(row.failures.size(), 5U) << detection;
    EXPECT_EQ(row.failures[0].outcome, Outcome::not_positive_definite);
    EXPECT_EQ(row.failures[0].step, 249);  // 4/3 4^249 is beyond 1e150
    EXPECT_TRUE(std::isnan(study.bound.position_squared));
  }
}

// The bound is that of filters which miss what they miss, and of noise that has one.
TEST(EstimatorStudy, TheBoundOfALinearWorldMissesMeasurementsToo) {
  const auto study = [](const std::string& noise) {
    const char* text =
        "[world]\nmodel = \"linear\"\nF = [[0.9]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
        "[study]\nruns = 64\nsteps = 50\n";
    return study_estimators(load_scenario_text(text, "s.toml", {&noise, 1}), {.estimators = {"kalman"}});
  };
  const EstimatorStudy all = study("noise.detection_probability=1");
  const EstimatorStudy missed = study("noise.detection_probability=0.3");
  // The Kalman filter of the same runs.
  for (const EstimatorStudy* s : {&all, &missed}) {
    const double claimed = s->rows[0].claimed_position_m;
    EXPECT_NEAR(s->bound.position_squared, claimed * claimed, 1e-9 * claimed * claimed);
    EXPECT_FALSE(s->has_vehicle);
  }
  EXPECT_GT(missed.bound.position_squared, 1.5 * all.bound.position_squared);
  const EstimatorStudy late = study("noise.measurement_delay=2");
  EXPECT_TRUE(std::isnan(late.bound.position_squared));
  EXPECT_EQ(late.rows[0].position_efficiency.count, 0);
}

TEST(EstimatorStudy, ThreadsChangeNoBit) {
  const Scenario s = load("huang_ring", {"study.runs=18", "study.steps=60"});
  const EstimatorStudy one = study_estimators(s, {.threads = 1}), three = study_estimators(s, {.threads = 3});
  ASSERT_EQ(one.rows.size(), estimator_kinds().size());
  for (std::size_t i = 0; i < one.rows.size(); ++i) {
    const EstimatorRow &a = one.rows[i], &b = three.rows[i];
    EXPECT_EQ(a.pose_nees, b.pose_nees);
    EXPECT_EQ(a.pose_bands, b.pose_bands);
    EXPECT_EQ(a.bands, b.bands);
    EXPECT_EQ(a.position_rmse_m.mean, b.position_rmse_m.mean);
    for (std::size_t block = 0; block < kEstimatorBlocks; ++block) {
      EXPECT_EQ(a.nees[block].upper, b.nees[block].upper);
    }
  }
}

// Common noise: an estimator less itself is nothing.
// One run of each estimator comes before all, for its rank and its time.
TEST(EstimatorStudy, IsStoppedBeforeItsFirstRunToo) {
  const std::atomic<bool> stop = true;
  const EstimatorStudy study =
      study_estimators(load("ukfm_slam2d", {"study.runs=2", "study.steps=20"}), {.stop = &stop});
  EXPECT_FALSE(study.complete);
  EXPECT_TRUE(study.rows.empty());
}

// Holm over both directions: of one estimator without a map the verdict is that of its interval; of three the
// least p-value is three times as large.
TEST(EstimatorStudy, BothDirectionsAreAdjustedForAllEstimators) {
  const Scenario scenario =
      load("linear_estimators",
           {"study.runs=24", "study.steps=50", "filter.process_scale=0.7", "filter.measurement_scale=0.7"});
  const std::vector<std::string> names = {"kalman", "steady-state", "own-gain"};
  const auto least_of = [](const EstimatorStudy& study) {
    double least = 1.0;
    for (const EstimatorRow& row : study.rows) {
      const DirectedPValues& p = row.p_values[static_cast<std::size_t>(EstimatorBlock::pose)];
      least = std::min({least, p.optimistic, p.pessimistic});
    }
    return least;
  };
  double least_alone = 1.0;
  for (const std::string& name : names)
    least_alone = std::min(least_alone, least_of(study_estimators(scenario, {.estimators = {name}})));
  ASSERT_LT(least_alone, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(least_of(study_estimators(scenario, {.estimators = names})), 3.0 * least_alone);
}

// One sided or by its own interval, a filter that claims too much would pass.
TEST(EstimatorStudy, PessimisticIsInconsistentAsOptimisticIs) {
  const auto verdict = [](const std::string& scale) {
    const EstimatorStudy study = study_estimators(
        load("linear_estimators", {"study.runs=24", "study.steps=50", "filter.measurement_scale=" + scale,
                                   "filter.process_scale=" + scale}),
        {.estimators = {"kalman"}});
    const Verdict word = verdict_of(study.rows[0], EstimatorBlock::pose, study.scenario.study.confidence);
    const MeanInterval& interval = nees(study.rows[0], EstimatorBlock::pose);
    EXPECT_EQ(word == Verdict::optimistic, interval.lower > 1.0) << scale;
    EXPECT_EQ(word == Verdict::pessimistic, interval.upper < 1.0) << scale;
    EXPECT_EQ(any_inconsistent(study), word != Verdict::consistent) << scale;
    return word;
  };
  EXPECT_EQ(verdict("1"), Verdict::consistent);
  EXPECT_EQ(verdict("10"), Verdict::pessimistic);
  EXPECT_EQ(verdict("0.1"), Verdict::optimistic);
}

TEST(EstimatorStudy, NoiseIsCommon) {
  const EstimatorStudy study = study_estimators(load("huang_ring", {"study.runs=20", "study.steps=50"}),
                                                {.estimators = {"fej", "fej"}});
  ASSERT_EQ(study.paired.size(), 2U);
  for (const PairedDifference& paired : study.paired) {
    EXPECT_EQ(paired.difference.mean, 0.0);
    EXPECT_EQ(paired.p_value, 1.0);
  }
}

// Runs that fail are counted and named, and in no average.
TEST(EstimatorStudy, FailedRunsAreNamed) {
  const EstimatorStudy study = study_estimators(
      load("huang_annulus",
           {"study.runs=20", "study.steps=500", "noise.turn_rate_std=1.0", "noise.speed_std=2.0"}),
      {.estimators = {"ekf"}});
  const EstimatorRow& row = study.rows.front();
  ASSERT_FALSE(row.failures.empty());
  EXPECT_EQ(row.runs + std::ssize(row.failures), 20);
  EXPECT_TRUE(std::ranges::is_sorted(row.failures, {}, &RunFailure::run));
  for (const RunFailure& failure : row.failures) EXPECT_NE(failure.outcome, Outcome::ok);
  EXPECT_EQ(nees(row, EstimatorBlock::pose).count, row.runs);
}

TEST(EstimatorStudy, WhatItCannotCompareIsRefused) {
  const Scenario planar = load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml");
  EXPECT_THROW(study_estimators(planar, {}), std::invalid_argument);
  EXPECT_THROW(study_estimators(load("huang_ring"), {.estimators = {"magic"}}), std::invalid_argument);
}

// Gains that depend on no data need every measurement.
TEST(EstimatorStudy, OfAllEstimatorsThoseThatRefuseTheScenarioAreLeftOut) {
  const Scenario misses = load("linear_estimators", {"noise.detection_probability=0.8", "study.runs=4"});
  const EstimatorStudy study = study_estimators(misses, {});
  ASSERT_EQ(study.rows.size(), 1U);
  EXPECT_EQ(study.rows[0].name, "kalman");
  const auto smoother = std::ranges::find(study.left_out, "smoother", &LeftOutEstimator::name);
  ASSERT_NE(smoother, study.left_out.end());
  EXPECT_THAT(smoother->reason, ::testing::HasSubstr("needs every measurement"));
  EXPECT_THROW(study_estimators(misses, {.estimators = {"kalman", "smoother"}}), std::invalid_argument);
}

// What goes to and fro between two places is counted, by any threads.
TEST(EstimatorStudy, CountsWhereAnIterationDidNotSettle) {
  const Scenario annulus =
      load("huang_annulus", {"study.runs=10", "study.steps=120", "noise.turn_rate_std=0.5"});
  const auto study = [&](int threads) {
    return study_estimators(annulus, {.estimators = {"smoother", "ekf"}, .threads = threads});
  };
  const EstimatorStudy one = study(1), two = study(2);
  EXPECT_FALSE(one.rows[0].not_converged.empty());
  EXPECT_EQ(one.rows[0].not_converged, two.rows[0].not_converged);
  EXPECT_TRUE(one.rows[1].not_converged.empty());
}

}  // namespace
}  // namespace credence::internal
