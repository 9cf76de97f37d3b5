#include "reports/document/study/plan_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SweepPlan planned_sweep(const std::string& sizes) {
  SweepPlan plan = plan_sweep(read_scenario_text(
      "[world]\nmodel = \"monobot\"\n[study]\nruns = 128\nsteps = 10\n" + sizes, "sizes.toml"));
  return plan;
}

/// 0.02 s a run on four threads; NEES takes `runs` to find a factor 1.2, and 1.5 times as many its inverse.
StudyPlan plan_of(const Scenario& scenario, std::int64_t runs) {
  StudyPlan plan;
  plan.scenario = scenario;
  plan.pilot = {.runs = 8, .seconds = 0.5, .seconds_per_run = 0.02, .threads = 4};
  plan.correlation = CorrelationSource::pilot;
  plan.nees.design = {.steps = 10, .dof_per_step = 3.0, .effective_steps = 4.25};
  plan.nis.design = {.steps = 10, .dof_per_step = 2.0};
  plan.nees.detections = {
      {1.2, {runs, 0.91}, {runs + 60, 0.9}, 0.02 * static_cast<double>(runs)},
      {1.0 / 1.2, {runs + runs / 2, 0.92}, {2 * runs, 0.9}, 0.03 * static_cast<double>(runs)}};
  plan.nis.detections = {{1.2, {runs / 2, 0.93}, {runs, 0.9}, 0.01 * static_cast<double>(runs)}};
  plan.nees.detectable = {.below = 0.8, .above = 1.3};
  plan.nis.detectable = {.below = 0.9, .above = 1.1};
  plan.runs_for_precision = 70;
  plan.runs_for_all = runs + runs / 2;
  plan.chunk_bytes = 1e6;
  return plan;
}

const ReportTable& planned_table(const Document& document) {
  return std::get<ReportTable>(document.brief.front());
}

std::vector<std::string> plan_words(const std::vector<TableCell>& row) {
  std::vector<std::string> texts;
  for (const TableCell& cell : row) texts.push_back(cell.text);
  return texts;
}

TEST(PlanReport, AFactorNearOneIsNotShownAsOne) {
  const SweepPlan sweep = planned_sweep("");
  StudyPlan plan = plan_of(sweep.points[0].scenario, 200);
  plan.nees.detections = {{1.0001, {200, 0.91}, {250, 0.9}, 1.0},
                          {1.0 / 1.0001, {200, 0.91}, {250, 0.9}, 1.0}};
  const Document document = plan_document(sweep, {plan});
  const ReportTable& table = planned_table(document);
  EXPECT_EQ(table.rows[0][0].text, "NEES verdict optimistic at a factor 1.0001");
  EXPECT_EQ(table.rows[1][0].text, "NEES verdict pessimistic at a factor 0.99990");
}

TEST(PlanReport, OneConfigurationHasARowForEachQuestion) {
  const SweepPlan sweep = planned_sweep("");
  const Document document = plan_document(sweep, {plan_of(sweep.points[0].scenario, 200)});
  const ReportTable& table = planned_table(document);
  ASSERT_EQ(table.rows.size(), 4U);
  EXPECT_THAT(plan_words(table.rows[0]),
              ElementsAre("NEES verdict optimistic at a factor 1.20", "200", "91.0", "4.0 s", "260"));
  EXPECT_THAT(plan_words(table.rows[1]),
              ElementsAre("NEES verdict pessimistic at a factor 0.833", "300", "92.0", "6.0 s", "400"));
  EXPECT_THAT(plan_words(table.rows[2]),
              ElementsAre("NIS verdict optimistic at a factor 1.20", "100", "93.0", "2.0 s", "200"));
  EXPECT_THAT(plan_words(table.rows[3]), ElementsAre("mean NEES to ±5 %", "70", "", "1.4 s", ""));
  EXPECT_THAT(table.notes,
              testing::Contains(HasSubstr("The 128 runs of the scenario show in NEES a factor below "
                                          "0.8000 or above 1.300 with 90 % power.")));
  EXPECT_THAT(table.notes, testing::Contains(HasSubstr("worth 4.25 independent ones (pilot)")));
}

// Else 121 runs that take 409 ms stand beside a pilot of 4096 in 23 ms.
TEST(PlanReport, NamesTheTimeOfLookingAtTheFirstRunsStepByStep) {
  const SweepPlan sweep = planned_sweep("");
  StudyPlan plan = plan_of(sweep.points[0].scenario, 200);
  const auto notes = [&] { return planned_table(plan_document(sweep, {plan})).notes; };
  EXPECT_THAT(notes(),
              testing::Contains("Times are expected ones, from a pilot of 8 runs in 500 ms on 4 threads."));
  plan.pilot.evidence_runs = 1000;
  plan.pilot.evidence_seconds_per_run = 0.0034;
  plan.pilot.threads = 1;
  EXPECT_THAT(notes(), testing::Contains(
                           "Times are expected ones, from a pilot of 8 runs in 500 ms on 1 thread; the first "
                           "1000 runs of a study are looked at step by step as well, which takes 3.4 ms more "
                           "for each."));
}

TEST(PlanReport, TheDataOfOneConfigurationAreOfTheSameNumbers) {
  const SweepPlan sweep = planned_sweep("");
  const StudyPlan plan = plan_of(sweep.points[0].scenario, 200);
  const auto j = nlohmann::json::parse(plan_document(sweep, {plan}).json());
  EXPECT_EQ(j["scenario"], "sizes");
  EXPECT_EQ(j["runs"], 300);
  EXPECT_NEAR(j["seconds"].get<double>(), 6.0, 1e-12);
  EXPECT_EQ(j["nees"]["detect"][1]["runs"], 300);
  EXPECT_EQ(j["nees"]["detect"][1]["word_runs"], 400);
  EXPECT_EQ(j["nees"]["detect"][1]["factor"], 1.0 / 1.2);
  EXPECT_EQ(j["nees"]["detectable"]["below"], 0.8);
  EXPECT_EQ(j["nees"]["detectable"]["above"], 1.3);
  EXPECT_EQ(j["nis"]["detect"].size(), 1U);
  EXPECT_EQ(j["nees"]["effective_steps"], 4.25);
  EXPECT_FALSE(j["nis"].contains("effective_steps")) << "NIS of a consistent filter is white";
  EXPECT_EQ(j["precision"]["runs"], 70);
  EXPECT_NEAR(j["precision"]["seconds"].get<double>(), 1.4, 1e-12);
  EXPECT_FALSE(j.contains("sweep"));
  // 128 runs are two chunks of 64, each 64 · 0.02 s · 4 threads of one core.
  EXPECT_EQ(j["cost"]["chunks"], 2);
  EXPECT_NEAR(j["cost"]["core_seconds"].get<double>(), 128 * 0.02 * 4, 1e-9);
  EXPECT_NEAR(j["cost"]["seconds_on_10000_cores"].get<double>(), 64 * 0.02 * 4, 1e-9);
}

TEST(PlanReport, OfASweepEveryPlannedConfigurationAndTheCostOfAll) {
  const SweepPlan sweep = planned_sweep("[sweep]\nworld.landmarks = [1, 2, 3, 4]\n");
  // Planned in another order, and not all.
  const std::vector<StudyPlan> plans = {plan_of(sweep.points[2].scenario, 400),
                                        plan_of(sweep.points[0].scenario, 200)};
  const Document document = plan_document(sweep, plans);
  const ReportTable& table = planned_table(document);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_THAT(plan_words(table.rows[0]), ElementsAre("world.landmarks = 3", "800", "400", "70", "12 s"));
  EXPECT_THAT(plan_words(table.rows[1]), ElementsAre("world.landmarks = 1", "400", "200", "70", "6.0 s"));
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["sweep"]["configurations"], 4);
  EXPECT_EQ(j["sweep"]["planned"], 2);
  EXPECT_EQ(j["sweep"]["runs"], 600);
  EXPECT_NEAR(j["sweep"]["seconds"].get<double>(), 4 * 600 * 0.02, 1e-9);
  EXPECT_EQ(j["sweep"]["runs_in_scenario"], 128);
  EXPECT_NEAR(j["sweep"]["seconds_in_scenario"].get<double>(), 4 * 128 * 0.02, 1e-9);
  ASSERT_EQ(j["configurations"].size(), 2U);
  EXPECT_EQ(j["configurations"][0]["runs"], 600);
  EXPECT_EQ(j["cost"]["chunks"], 8);
  EXPECT_THAT(table.notes,
              testing::Contains(HasSubstr("The sweep of 4 configurations with 600 runs each: 48 s")));
}

}  // namespace
}  // namespace credence::internal
