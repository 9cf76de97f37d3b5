#include "analysis/evidence/sweep_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/nan.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

SweepPlan plan_of(const std::vector<Scenario>& scenarios) {
  SweepPlan plan{.name = "s", .axes = {}, .points = {}};
  for (const Scenario& scenario : scenarios)
    plan.points.push_back({configuration_id(scenario), {}, scenario});
  return plan;
}

Scenario inflated(Index rank) {
  Scenario scenario = default_scenario("monobot");
  scenario.filter.inflation = rank == 0 ? FilterInflation::none : FilterInflation::rank;
  scenario.filter.inflation_rank = rank;
  scenario.filter.inflation_scale = 0.1;
  scenario.study = {.runs = 4, .steps = 4};
  return scenario;
}

StudyAnalysis study_of(const Scenario& scenario) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  return analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {}).front()));
}

TEST(SweepAnalysis, EachStudyIsThatOfItsPointAlsoWhereOthersHaveNone) {
  const std::vector<Scenario> scenarios = {inflated(0), inflated(1), inflated(2)};
  std::vector<StudyAnalysis> studies = {study_of(scenarios[0]), study_of(scenarios[2])};
  const SweepAnalysis sweep = analyse_sweep(plan_of(scenarios), studies);
  EXPECT_EQ(sweep.points, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(sweep.point(1).scenario, scenarios[2]);
  EXPECT_EQ(sweep.p_values, sweep_p_values(studies));
  EXPECT_TRUE(sweep.rank_map.empty()) << "one point is no cell of a map";
}

TEST(SweepAnalysis, AMapOfRanksHasACellForEveryStudy) {
  const std::vector<Scenario> scenarios = {inflated(1), inflated(2)};
  const SweepAnalysis sweep =
      analyse_sweep(plan_of(scenarios), {study_of(scenarios[0]), study_of(scenarios[1])});
  ASSERT_EQ(sweep.rank_map.size(), 2U);
  EXPECT_EQ(sweep.rank_map[0].inflation_rank, 1);
  EXPECT_EQ(sweep.rank_map[1].inflation_rank, 2);
  EXPECT_TRUE(analyse_sweep(plan_of(scenarios), {}).rank_map.empty());
}

TEST(SweepAnalysis, RefusesAStudyOfNoPoint) {
  EXPECT_THROW(analyse_sweep(plan_of({inflated(1)}), {study_of(inflated(2))}), std::invalid_argument);
}

StudyAnalysis study(double word_p) {
  StudyAnalysis a;
  a.word.p_value = word_p;
  return a;
}

TEST(SweepVerdicts, AdjustTheWordForAllConfigurations) {
  // Benjamini-Yekutieli over three tests by hand, Σ 1/i = 11/6.
  const std::vector<StudyAnalysis> sweep = {study(0.002), study(0.04), study(1.0)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_NEAR(p[0], 0.002 * 3 * 11.0 / 6.0, 1e-15);
  EXPECT_NEAR(p[1], 0.04 * 1.5 * 11.0 / 6.0, 1e-15);
  EXPECT_EQ(p[2], 1.0);
}

TEST(SweepVerdicts, AnUndecidedConfigurationIsNoMemberOfTheFamily) {
  const std::vector<StudyAnalysis> sweep = {study(kNaN), study(0.01)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_TRUE(std::isnan(p[0]));
  EXPECT_NEAR(p[1], 0.01, 1e-15);
}

TEST(SweepVerdicts, AStopRuleSpeaksForItsStudy) {
  std::vector<StudyAnalysis> sweep = {study(1e-9)};
  sweep[0].stop.emplace().p_value = 0.3;
  EXPECT_NEAR(sweep_p_values(sweep)[0], 0.3, 1e-15);
}

}  // namespace
}  // namespace credence::internal
