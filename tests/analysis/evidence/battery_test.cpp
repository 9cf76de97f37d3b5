#include "analysis/evidence/battery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/study_analysis.h"
#include "core/nan.h"
#include "montecarlo/engine/engine.h"

namespace credence {
namespace {

Scenario monobot(std::int64_t runs) {
  Scenario s = default_scenario(WorldModel::monobot);
  s.world.landmarks = 2;
  s.study.runs = runs;
  s.study.steps = 60;
  s.study.seed = 5;
  return s;
}

Scenario planar() {
  Scenario s = default_scenario(WorldModel::planar);
  s.world.landmarks = 6;
  s.study.runs = 70;
  s.study.steps = 40;
  s.study.seed = 3;
  return s;
}

StudyAnalysis analysed(const Scenario& scenario) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  StudyAnalysis analysis = analyse_study(scenario, *experiment, run_studies({&task, 1}, {}).front());
  add_battery(analysis, *experiment);
  return analysis;
}

const BatteryTest& test_of(const Battery& battery, const std::string& name) {
  const auto found = std::ranges::find(battery.tests, name, &BatteryTest::name);
  if (found == battery.tests.end()) throw std::runtime_error("no test " + name);
  return *found;
}

bool names(const Battery& battery, Cause cause) {
  return std::ranges::any_of(battery.causes, [&](const CauseFound& c) { return c.cause == cause; });
}

TEST(Battery, PassesAnOptimalFilter) {
  const StudyAnalysis analysis = analysed(monobot(320));
  const Battery& battery = analysis.battery.value();
  EXPECT_EQ(battery.runs, 320);
  EXPECT_EQ(battery.tests.size(), 2U + 4U + 3U + 2U + 3U);
  for (const BatteryTest& test : battery.tests) {
    // The chance of a false alarm anywhere in the battery, at this one seed, is below 0.1 %.
    EXPECT_GT(test.adjusted, 1e-3) << test.name << ": " << test.says;
  }
  EXPECT_TRUE(battery.causes.empty());
  EXPECT_EQ(battery.responsible.index, -1);
  EXPECT_FALSE(battery.responsible.joint_only);
}

TEST(Battery, SeesTheSameNumbersAsTheEngine) {
  for (const Scenario& scenario : {monobot(70), planar()}) {
    const StudyAnalysis analysis = analysed(scenario);
    const auto experiment = make_experiment(scenario);
    const BatteryStatistics s = collect_battery(scenario, *experiment, 70, {.threads = 1}).value();
    Moments nees;
    for (const StepStatistics& step : analysis.statistics.steps) nees.merge(step[Quantity::nees]);
    ASSERT_EQ(s.whole_runs.nees_values.count, nees.count);
    EXPECT_NEAR(s.whole_runs.nees_values.mean, nees.mean, 1e-10 * nees.mean);
    EXPECT_NEAR(s.whole_runs.nees_values.m2, nees.m2, 1e-9 * nees.m2);
    if (!analysis.vehicle_nees) continue;
    for (std::size_t k = 0; k < analysis.statistics.steps.size(); ++k) {
      const Moments& pose = analysis.statistics.steps[k][Quantity::vehicle_nees];
      EXPECT_EQ(s.blocks.series()[0].nees[k].count, pose.count);
      EXPECT_NEAR(s.blocks.series()[0].nees[k].mean, pose.mean, 1e-9 * pose.mean) << "step " << k + 1;
    }
  }
}

TEST(Battery, IsTheSameForAnyNumberOfThreads) {
  const Scenario scenario = planar();
  const auto experiment = make_experiment(scenario);
  const BatteryStatistics one = collect_battery(scenario, *experiment, 70, {.threads = 1}).value();
  const BatteryStatistics three = collect_battery(scenario, *experiment, 70, {.threads = 3}).value();
  EXPECT_EQ(one.innovations.nis, three.innovations.nis);
  EXPECT_EQ(one.innovations.far_tail, three.innovations.far_tail);
  for (Index lag = 0; lag <= InnovationStatistics::kLags; ++lag) {
    EXPECT_EQ(one.innovations.products.product(lag), three.innovations.products.product(lag));
  }
  for (std::size_t b = 0; b < one.blocks.series().size(); ++b) {
    EXPECT_EQ(one.blocks.series()[b].nees, three.blocks.series()[b].nees) << one.blocks.series()[b].name;
    EXPECT_EQ(one.blocks.series()[b].dof, three.blocks.series()[b].dof);
  }
  EXPECT_EQ(one.whole_runs.nees, three.whole_runs.nees);
  EXPECT_EQ(one.innovations.run_mean.scatter, three.innovations.run_mean.scatter);
}

TEST(Battery, NamesAWrongMeasurementNoiseAndTheFactorThatMendsIt) {
  Scenario scenario = monobot(320);
  scenario.filter.measurement_scale = 0.5;
  const Battery battery = analysed(scenario).battery.value();
  EXPECT_TRUE(names(battery, Cause::measurement_noise_too_small));
  EXPECT_LT(test_of(battery, "whiteness of the innovation").adjusted, 1e-6);
  EXPECT_LT(test_of(battery, "NIS against its law, tails").adjusted, 1e-6);
  EXPECT_GT(battery.scale_innovation.lower, 1.0);
  EXPECT_GT(battery.scale_covariance.lower, 1.0);
  // Twice the assumed R is the truth; the advice is of first order.
  EXPECT_GT(battery.scale_measurement_noise.factor, 1.5);
  EXPECT_LT(battery.scale_measurement_noise.factor, 2.5);
}

TEST(Battery, FindsTheBlocksOfThePlane) {
  const Battery battery = analysed(planar()).battery.value();
  ASSERT_EQ(battery.blocks.size(), 3U + 6U + 1U);
  EXPECT_EQ(battery.blocks[0].name, "pose");
  EXPECT_NEAR(battery.blocks[0].verdict.expected, 3.0, 1e-12);
  EXPECT_NEAR(battery.blocks[1].verdict.expected, 2.0, 1e-12);
  EXPECT_NEAR(battery.blocks[2].verdict.expected, 1.0, 1e-12);
  EXPECT_NEAR(battery.blocks[3].verdict.expected, 2.0, 1e-12);
  EXPECT_EQ(battery.blocks.back().name, "all landmarks");
}

TEST(Battery, NamesTheLinearisationWhereOnlyTheErrorsAreWrong) {
  Scenario scenario = planar();
  scenario.world.landmarks = 10;
  scenario.study.steps = 250;
  const StudyAnalysis analysis = analysed(scenario);
  ASSERT_EQ(analysis.nees.verdict, Verdict::optimistic);
  ASSERT_EQ(analysis.nis.verdict, Verdict::consistent);
  EXPECT_TRUE(names(*analysis.battery, Cause::linearisation));
}

TEST(Battery, CountsCoverageAgainstItsLaw) {
  const Battery battery = analysed(monobot(320)).battery.value();
  // Three states: P(χ²(3) ≤ k²), tables of the χ² law.
  EXPECT_NEAR(battery.coverage[0].expected, 0.198748, 1e-6);
  EXPECT_NEAR(battery.coverage[1].expected, 0.738536, 1e-6);
  EXPECT_NEAR(battery.coverage[2].expected, 0.970709, 1e-6);
  EXPECT_EQ(battery.coverage[0].pooled.total, 320 * 60);
}

TEST(Battery, LeavesOutAStepThatFailed) {
  const BatteryShape shape{
      .steps = 3, .vehicle_dim = 1, .landmark_dim = 1, .landmarks = 0, .innovation_dim = 1};
  BatteryStatistics s(shape);
  TraceStep step{.truth = Vector::Zero(1), .estimate = Vector::Ones(1), .P = Matrix::Identity(1, 1)};
  s.begin_run();
  s.add(step);
  step.nees = 1.0;
  step.nees_dof = 1;
  s.add(step);
  step.P(0, 0) = kNaN;
  step.nees_dof = 0;
  s.add(step);
  s.end_run(Outcome::not_positive_definite);
  EXPECT_EQ(s.runs, 1);
  EXPECT_EQ(s.blocks.series()[0].nees[0].count, 1);
  EXPECT_EQ(s.blocks.series()[0].nees[1].count, 0);
  EXPECT_TRUE(s.whole_runs.nees.empty());
  const ConsistencyVerdict nothing = judge_nees({}, {}, 0.95);
  EXPECT_EQ(judge_battery(s, nothing, nothing).runs, 1);
}

TEST(Battery, StopsWhenAsked) {
  const Scenario scenario = monobot(320);
  const std::atomic<bool> stop = true;
  EXPECT_FALSE(
      collect_battery(scenario, *make_experiment(scenario), 320, {.threads = 2, .stop = &stop}).has_value());
}

TEST(Battery, LooksAtNoMoreRunsThanItCanAfford) {
  Scenario scenario = monobot(1000000);
  EXPECT_EQ(battery_runs(scenario, 1000000), 1024);
  EXPECT_EQ(battery_runs(scenario, 17), 17);
  scenario.world.landmarks = 300;
  EXPECT_EQ(battery_runs(scenario, 1000000) % kChunkRuns, 0);
  EXPECT_LT(battery_runs(scenario, 1000000), 1024);
}

}  // namespace
}  // namespace credence
