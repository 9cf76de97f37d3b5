#include "analysis/evidence/sweep_analysis.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "analysis/evidence/sweep_verdicts.h"
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

}  // namespace
}  // namespace credence::internal
