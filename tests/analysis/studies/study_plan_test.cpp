#include "analysis/studies/study_plan.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/effective_steps.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/studies/selftest_study.h"
#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/worlds/registry.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

struct Power {
  double nees = 0.0, nis = 0.0;
};

// Share of studies that the verdicts reject when the true covariance is `factor` times the claimed one: all
// three variances that the filter assumes are too small by it, which leaves its gain right.
Power simulated_power(double factor, std::int64_t runs, int studies) {
  const double assumed = 1.0 / factor;
  const SyntheticFilter filter(
      {.process_scale = assumed, .measurement_scale = assumed, .initial_scale = assumed});
  const NoiseSource noise(11, 1);
  const std::int64_t blocks = (runs + SyntheticFilter::kRuns - 1) / SyntheticFilter::kRuns;
  Power power;
  for (int study = 0; study < studies; ++study) {
    const StudyStatistics s = synthetic_evidence(filter, noise, study * blocks, static_cast<int>(runs)).study;
    const ConsistencyVerdict nees =
        judge_nees(s.series(Quantity::nees), s.dofs(Quantity::nees), 0.95, &s.nees_of_runs);
    const ConsistencyVerdict nis = judge_nis(s.series(Quantity::nis), s.dofs(Quantity::nis), 0.95);
    power.nees += is_inconsistent(nees.verdict) ? 1.0 : 0.0;
    power.nis += is_inconsistent(nis.verdict) ? 1.0 : 0.0;
  }
  power.nees /= studies;
  power.nis /= studies;
  return power;
}

TEST(StudyPlan, PlannedRunsHaveThePlannedPower) {
  constexpr int kStudies = 300;
  const SyntheticFilter filter({});
  VerdictDesign design{.steps = SyntheticFilter::kSteps, .dof_per_step = 2.0};
  design.effective_steps = linear_run_law(filter.transitions(), filter.covariances()).effective_steps;
  VerdictDesign white = design;
  white.white = true;
  design = simulated(design, 1000);
  for (const double factor : {1.6, 1.0 / 1.6}) {
    const RunsNeeded nees = runs_to_detect(design, factor, 0.8);
    const double error = test::binomial_standard_error(nees.power, kStudies);
    const double measured = simulated_power(factor, nees.runs, kStudies).nees;
    // A lower bound: the two parts of the verdict help each other.
    EXPECT_GE(measured, nees.power - 5.0 * error) << factor;
    EXPECT_LE(measured, nees.power + 0.08 + 5.0 * error) << factor;
    // Half the runs do not do.
    EXPECT_LT(simulated_power(factor, nees.runs / 2, kStudies).nees, nees.power - error) << factor;
    RecordProperty("nees_runs", std::to_string(nees.runs));
    RecordProperty("nees_measured", std::to_string(measured));
  }
  for (const double factor : {1.2, 1.0 / 1.2}) {
    const RunsNeeded nis = runs_to_detect(white, factor, 0.8);
    const double error = test::binomial_standard_error(nis.power, kStudies);
    const double measured = simulated_power(factor, nis.runs, kStudies).nis;
    EXPECT_GE(measured, nis.power - 5.0 * error) << factor;
    EXPECT_LE(measured, nis.power + 0.05 + 5.0 * error) << factor;
  }
}

Scenario short_monobot() {
  Scenario scenario = default_scenario("monobot");
  scenario.study.steps = 20;
  return scenario;
}

TEST(StudyPlan, LinearScenarioIsPlannedByItsExactLaw) {
  const Scenario scenario = short_monobot();
  const auto experiment = make_experiment(scenario);
  const StudyPlan plan = plan_study(scenario, *experiment, {.factor = 1.3, .threads = 1});
  EXPECT_EQ(plan.correlation, CorrelationSource::exact_law);
  EXPECT_EQ(plan.nees.design.steps, 20.0);
  EXPECT_EQ(plan.nees.design.dof_per_step, 3.0);
  EXPECT_EQ(plan.nis.design.dof_per_step, 2.0);
  EXPECT_GT(plan.nees.design.effective_steps, 1.0);
  EXPECT_LT(plan.nees.design.effective_steps, 20.0);
  ASSERT_EQ(plan.nees.detections.size(), 2U);
  EXPECT_EQ(plan.nees.detections[0].factor, 1.3);
  EXPECT_GE(plan.nees.detections[0].needed.power, 0.9);
  EXPECT_EQ(plan.nees.detections[0].needed.runs, runs_to_detect(plan.nees.design, 1.3, 0.9).runs);
  EXPECT_LE(plan.nis.detections[0].needed.runs, plan.nees.detections[0].needed.runs);
  EXPECT_GE(plan.runs_for_all, plan.runs_for_precision);
  EXPECT_GT(plan.pilot.seconds_per_run, 0.0);
}

TEST(StudyPlan, TheWordTakesMoreRunsAsItHasAShareForEachVerdict) {
  const Scenario scenario = short_monobot();
  const auto experiment = make_experiment(scenario);
  const StudyPlan plan = plan_study(scenario, *experiment, {.factor = 1.3, .threads = 1, .evidence = false});
  EXPECT_EQ(plan.pilot.evidence_runs, 0) << "a sweep takes none";
  EXPECT_EQ(plan.pilot.seconds_for(10), 10 * plan.pilot.seconds_per_run);
  // NEES 4 of 13, NIS of two components 1 of 13 parts of 5 %.
  const std::pair<const VerdictPlan*, double> verdicts[] = {{&plan.nees, 4.0 / 13.0},
                                                            {&plan.nis, 1.0 / 13.0}};
  for (const auto& [verdict, share] : verdicts) {
    VerdictDesign design = verdict->design;
    design.confidence = 1.0 - 0.05 * share;
    for (const DetectionPlan& detection : verdict->detections) {
      EXPECT_EQ(detection.word.runs, runs_to_detect(design, detection.factor, 0.9).runs);
      EXPECT_GT(detection.word.runs, detection.needed.runs);
      EXPECT_GE(plan.runs_for_all, detection.word.runs);
    }
  }
}

TEST(StudyPlan, TheEvidenceOfTheFirstRunsTakesItsTime) {
  const PilotTiming pilot{.seconds_per_run = 0.25, .evidence_runs = 100, .evidence_seconds_per_run = 0.5};
  EXPECT_EQ(pilot.seconds_for(10), 7.5);
  EXPECT_EQ(pilot.seconds_for(200), 100.0);
  const Scenario scenario = short_monobot();
  const StudyPlan plan = plan_study(scenario, *make_experiment(scenario), {.threads = 1});
  EXPECT_EQ(plan.pilot.evidence_runs, evidence_runs(scenario, scenario.study.runs));
}

TEST(StudyPlan, ExactLawAgreesWithItsRuns) {
  const Scenario scenario = short_monobot();
  const auto experiment = make_experiment(scenario);
  constexpr std::int64_t kPlayed = 400;
  std::vector<std::vector<double>> nees(kPlayed);
  for (std::int64_t run = 0; run < kPlayed; ++run) {
    bool start = true;
    experiment->visit(run, [&](const TraceStep& step) {
      if (!std::exchange(start, false)) nees[static_cast<std::size_t>(run)].push_back(step.nees);
    });
  }
  const double measured = measured_effective_steps(nees);
  const StudyPlan plan = plan_study(scenario, *experiment, {.threads = 1});
  // The variance of a variance: √(2/400) and the kurtosis of χ² make about 10 %, of which three.
  EXPECT_NEAR(measured / plan.nees.design.effective_steps, 1.0, 0.3);
}

// By the clock it would be another one each time, and with it the skewness and the runs that are planned.
TEST(StudyPlan, ThePilotsSizeIsThatOfTheQuestion) {
  const auto planned = [](const Scenario& scenario) {
    return plan_study(scenario, *make_experiment(scenario), {.threads = 1, .evidence = false});
  };
  Scenario scenario = default_scenario("pendulum");
  scenario.study.steps = 5;
  scenario.study.runs = 800;
  EXPECT_EQ(planned(scenario).pilot.runs, 80);
  scenario.study.runs = 10;
  EXPECT_EQ(planned(scenario).pilot.runs, 64);
  scenario = short_monobot();
  EXPECT_EQ(planned(scenario).pilot.runs, 4096);
  scenario.study.steps = 10'000;
  const std::size_t states = make_experiment(scenario)->layout().states.size();
  EXPECT_EQ(planned(scenario).pilot.runs, 20'000 / static_cast<std::int64_t>(states * states));
}

TEST(StudyPlan, CostOfASweepIsThatOfAllConfigurations) {
  const Scenario scenario = short_monobot();
  StudyPlan plan;
  plan.scenario = scenario;
  plan.pilot.seconds_per_run = 0.01;
  plan.runs_for_all = 300;
  StudyPlan slow = plan;
  slow.pilot.seconds_per_run = 0.03;
  slow.runs_for_all = 500;
  const std::vector<StudyPlan> plans{plan, slow};
  const SweepCost cost = sweep_cost(plans, 10);
  EXPECT_EQ(cost.runs, 500);
  EXPECT_NEAR(cost.seconds, 10 * 0.02 * 500, 1e-9);
  EXPECT_NEAR(cost.scenario_seconds, 10 * 0.02 * static_cast<double>(scenario.study.runs), 1e-9);
  EXPECT_EQ(sweep_cost({}, 0).runs, 0);
}

TEST(StudyPlan, CostOfAJobIsThatOfItsChunks) {
  StudyPlan one;
  one.scenario = default_scenario("monobot");
  one.scenario.study.runs = 130;  // three chunks, of which the last has two runs
  one.pilot = {.runs = 64, .seconds = 1.0, .seconds_per_run = 0.25, .threads = 2};
  one.chunk_bytes = 1000.0;
  const StudyPlan plans[] = {one, one};
  const JobCost cost = job_cost(plans, 10);
  EXPECT_EQ(cost.chunks, 30);
  EXPECT_DOUBLE_EQ(cost.core_seconds(), 10 * 130 * 0.5);
  EXPECT_DOUBLE_EQ(cost.disk_bytes, 30'000.0);
  EXPECT_DOUBLE_EQ(cost.memory_bytes, 10.0 * least_experiment_bytes(one.scenario));
  EXPECT_DOUBLE_EQ(cost.seconds_on(16), 2.0 * cost.chunk_seconds);
  EXPECT_DOUBLE_EQ(cost.seconds_on(10'000), cost.chunk_seconds);
}

TEST(StudyPlan, AChunkIsAsLargeAsItIsStored) {
  Scenario scenario = default_scenario("monobot");
  scenario.world.landmarks = 2;
  scenario.study.steps = 100;
  const auto experiment = make_experiment(scenario);
  const StudyPlan plan = plan_study(scenario, *experiment, {.threads = 1});
  const auto stored = static_cast<double>(packed(to_bytes(experiment->run_chunk(64, 64))).size());
  EXPECT_LT(stored, 12'000.0);
  EXPECT_NEAR(plan.chunk_bytes, stored, 0.1 * stored);
}

TEST(StudyPlan, RefusesImpossibleQuestions) {
  const Scenario scenario = short_monobot();
  const auto experiment = make_experiment(scenario);
  EXPECT_THROW(plan_study(scenario, *experiment, {.factor = 1.0, .threads = 1}), std::invalid_argument);
  EXPECT_THROW(plan_study(scenario, *experiment, {.factor = -2.0, .threads = 1}), std::invalid_argument);
  EXPECT_THROW(plan_study(scenario, *experiment, {.power = 1.0, .threads = 1}), std::invalid_argument);
  EXPECT_THROW(plan_study(scenario, *experiment, {.precision = 0.0, .threads = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
