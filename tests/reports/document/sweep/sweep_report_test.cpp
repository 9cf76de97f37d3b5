#include "reports/document/sweep/sweep_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/study_json.h"
#include "reports/document/verdict_text.h"
#include "reports/render/write_document.h"
#include "tests/reports/document/parts_of.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

/// Of `studied` points of a sweep of three.
SweepAnalysis sweep_of(std::size_t studied, const std::string& sizes = "[1, 2, 3]") {
  SweepPlan plan = plan_sweep(read_scenario_text(
      "[world]\nmodel = \"monobot\"\n[study]\nruns = 20\nsteps = 6\n[sweep]\nworld.landmarks = " + sizes +
          "\n",
      "sweep.toml"));
  plan.name = "sizes";
  std::vector<StudyAnalysis> studies;
  for (std::size_t i = 0; i < studied; ++i) {
    const Scenario& scenario = plan.points[i].scenario;
    const auto experiment = make_experiment(scenario);
    const StudyTask task{"", experiment.get(), scenario.study.runs};
    studies.push_back(analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {}).front())));
  }
  return analyse_sweep(std::move(plan), std::move(studies));
}

TEST(SweepDocument, HasARowForEveryConfigurationInTableDataAndFile) {
  const TemporaryFolder folder;
  const SweepAnalysis sweep = sweep_of(3);
  const Document document = sweep_document(sweep);
  const auto& table = std::get<ReportTable>(document.brief.front());
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[2].front().text, "3");
  const auto json = nlohmann::ordered_json::parse(document.json());
  ASSERT_EQ(json["configurations"].size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    auto study = json["configurations"][i];
    EXPECT_EQ(study["swept"]["world.landmarks"], i + 1);
    study.erase("swept");
    study.erase("sweep_p_value");
    EXPECT_EQ(study, as_read(study_json(sweep.studies[i]))) << "as run gives it";
  }
  write_document(document, folder.path(), {});
  const std::string csv = folder.read("sweep.csv");
  EXPECT_EQ(std::ranges::count(csv, '\n'), 1 + 3);
  EXPECT_THAT(csv, testing::HasSubstr(",nis_verdict,trace_last,verdict,sweep_p_value\r\n"));
  EXPECT_THAT(folder.read("index.html"), testing::HasSubstr("href=\"sweep.csv\""));
}

// Seven columns beside the settings, so that a page of 1200 pixels has room for all.
TEST(SweepDocument, APartHasItsMeanAndItsVerdictInOneCell) {
  const SweepAnalysis sweep = sweep_of(1);
  const Document document = sweep_document(sweep);
  const auto& table = std::get<ReportTable>(document.brief.front());
  std::vector<std::string> titles;
  for (const TableColumn& column : table.columns) titles.push_back(column.title);
  EXPECT_THAT(titles, testing::ElementsAre("world.landmarks", "verdict", "together", "NEES", "NIS",
                                           "last tr P (m²)", "runs", "failed"));
  const ConsistencyVerdict& nis = sweep.studies[0].nis;
  EXPECT_EQ(table.rows[0][4].text, fmt::format("{} ({})", against_expected(nis), to_string(nis.verdict)));
  EXPECT_THAT(against_expected(nis), testing::MatchesRegex("[0-9.]+ of 1.000"));
}

TEST(SweepDocument, AConfigurationWithFailedRunsIsCountedAndNotNearestToRight) {
  SweepAnalysis sweep = sweep_of(3);
  const std::string all_ran = sweep_document(sweep).answer.text;
  ASSERT_THAT(all_ran, testing::HasSubstr("nearest to right: "));
  EXPECT_THAT(all_ran, testing::Not(testing::HasSubstr("failed")));
  for (StudyAnalysis& study : sweep.studies) {
    study.statistics.failures = {{.run = 3, .step = 2, .outcome = Outcome::diverged}};
  }
  const ReportAnswer answer = sweep_document(sweep).answer;
  EXPECT_THAT(answer.text, testing::EndsWith("; runs failed in 3 of them"));
  EXPECT_EQ(answer.tone, CellTone::alarm);
}

// What is inconsistent by itself and by chance among so many is no reason to fail.
TEST(SweepDocument, AConfigurationThatDoesNotStandIsCountedAsThat) {
  SweepAnalysis sweep = sweep_of(3);
  for (StudyAnalysis& study : sweep.studies) study.word.verdict = Verdict::consistent;
  sweep.studies[1].word.verdict = Verdict::optimistic;
  sweep.p_values[1] = 0.2;
  EXPECT_FALSE(sweep.stands(1));
  EXPECT_THAT(
      sweep_document(sweep).answer.text,
      testing::StartsWith("Of 3 configurations 2 are consistent, 1 is inconsistent alone but not among so "
                          "many; nearest to right: "));
  const auto notes = [&] {
    const Document document = sweep_document(sweep);
    return std::get<ReportTable>(document.brief.front()).notes;
  };
  EXPECT_THAT(notes(), testing::Contains(testing::HasSubstr(
                           "1 of 3 is inconsistent alone, 0 stand; at most 5 % of those that stand are")));
  sweep.p_values[1] = 0.04;
  EXPECT_TRUE(sweep.stands(1));
  EXPECT_THAT(notes(), testing::Contains(testing::HasSubstr("1 of 3 is inconsistent alone, 1 stands; ")));
  EXPECT_FALSE(sweep.stands(0));
  EXPECT_THAT(sweep_document(sweep).answer.text,
              testing::StartsWith("Of 3 configurations 1 cannot be trusted, 2 are consistent; nearest"));
}

TEST(SweepDocument, TheAnswerAddsUpToAllConfigurations) {
  SweepAnalysis sweep = sweep_of(3);
  sweep.studies[0].word.verdict = Verdict::undecided;
  sweep.studies[1].word.verdict = Verdict::not_gaussian;
  sweep.studies[2].word.verdict = Verdict::pessimistic;
  sweep.p_values[2] = 1e-3;
  EXPECT_EQ(sweep_document(sweep).answer.text,
            "Of 3 configurations 1 is pessimistic, 1 is not Gaussian, 1 is undecided");
  sweep.studies[1].word.verdict = Verdict::undecided;
  sweep.studies[2].word.verdict = Verdict::mixed;
  EXPECT_EQ(sweep_document(sweep).answer.text, "Of 3 configurations 1 cannot be trusted, 2 are undecided");
}

TEST(SweepDocument, TheFileEndsWithTheVerdictOverAllAndWhetherItStands) {
  const TemporaryFolder folder;
  SweepAnalysis sweep = sweep_of(3);
  for (StudyAnalysis& study : sweep.studies) study.word.verdict = Verdict::consistent;
  sweep.studies[1].word.verdict = Verdict::not_gaussian;
  sweep.p_values = {0.5, 0.25, std::nan("")};
  write_document(sweep_document(sweep), folder.path(), {});
  std::istringstream csv(folder.read("sweep.csv"));
  std::vector<std::string> ends;
  for (std::string line; std::getline(csv, line);) {
    line.erase(line.find('\r'));
    ends.push_back(line.substr(line.rfind(',', line.rfind(',') - 1) + 1));
  }
  EXPECT_THAT(ends, testing::ElementsAre("verdict,sweep_p_value", "consistent,0.5", "not Gaussian,0.25",
                                         "consistent,"));
}

// A trace over states in metres and angles is in both; that of other worlds is in none.
TEST(SweepDocument, TheUnitOfATraceIsThatOfAllConfigurations) {
  SweepAnalysis sweep = sweep_of(3);
  const auto titles = [&] {
    const Document document = sweep_document(sweep);
    std::vector<std::string> all;
    for (const TableColumn& column : std::get<ReportTable>(document.brief.front()).columns)
      all.push_back(column.title);
    return all;
  };
  sweep.plan.points[2].scenario.world.model = "planar";
  EXPECT_THAT(titles(), testing::Contains("last tr P"));
  for (SweepPoint& point : sweep.plan.points) point.scenario.world.model = "planar";
  EXPECT_THAT(titles(), testing::Contains("last tr P (m² + rad²)"));
}

TEST(SweepDocument, TheColourIsThatOfTheWorstAndGreenOnlyWhereAllAreConsistent) {
  SweepAnalysis sweep = sweep_of(3);
  for (StudyAnalysis& study : sweep.studies) study.word.verdict = Verdict::consistent;
  const auto tone = [&] { return sweep_document(sweep).answer.tone; };
  EXPECT_EQ(tone(), CellTone::good);
  sweep.studies[1].word.verdict = Verdict::undecided;
  EXPECT_EQ(tone(), CellTone::caution);
  sweep.studies[1].word.verdict = Verdict::pessimistic;
  sweep.p_values[1] = 1e-3;
  EXPECT_EQ(tone(), CellTone::caution);
  sweep.studies[1].word.verdict = Verdict::optimistic;
  EXPECT_EQ(tone(), CellTone::alarm);
}

TEST(SweepDocument, OfAMapOfRanksATerminalShowsTheAnswer) {
  SweepAnalysis sweep = sweep_of(1);
  sweep.rank_map = {{.landmarks = 1, .inflation_rank = 1, .observability_rank = 1, .bounded = true}};
  const Document document = sweep_document(sweep);
  EXPECT_EQ(std::get<std::string>(document.brief.front()), document.answer.text + ".");
}

TEST(SweepDocument, SaysHowManyHaveNoResultsYet) {
  const Document document = sweep_document(sweep_of(1));
  const auto& table = std::get<ReportTable>(document.brief.front());
  EXPECT_EQ(table.rows.size(), 1U);
  EXPECT_THAT(table.notes, testing::Contains("1 of 3 configurations have results"));
  EXPECT_THAT(document.answer.text,
              testing::StartsWith("Of the 1 of 3 configurations that have results so far "));
}

TEST(SweepDocument, OneConfigurationIsNotCounted) {
  SweepAnalysis one = sweep_of(1, "[2]");
  StudyAnalysis& study = one.studies.front();
  study.word.verdict = Verdict::consistent;
  EXPECT_EQ(sweep_document(one).answer.text, "The only configuration is consistent");
  study.word.verdict = Verdict::undecided;
  EXPECT_EQ(sweep_document(one).answer.text, "The only configuration is undecided");
  study.statistics.failures = {{.run = 3, .step = 2, .outcome = Outcome::diverged}};
  const ReportAnswer failed = sweep_document(one).answer;
  EXPECT_EQ(failed.text, "The only configuration is undecided; runs of it failed");
  EXPECT_EQ(failed.tone, CellTone::caution);
}

TEST(SweepDocument, NamesTheConfigurationsInWhichAnIterationDidNotSettle) {
  SweepAnalysis sweep = sweep_of(3);
  const auto said = [&] {
    const Document document = sweep_document(sweep);
    std::vector<std::string> notes;
    for (const std::string& note : std::get<ReportTable>(document.brief.front()).notes) {
      if (note.find("converged") != std::string::npos) notes.push_back(note);
    }
    return notes;
  };
  EXPECT_THAT(said(), testing::IsEmpty());
  sweep.studies[1].statistics.not_converged = {{.run = 3, .steps = 2}, {.run = 7, .steps = 1}};
  EXPECT_THAT(said(), testing::ElementsAre(testing::HasSubstr(
                          "in 1 of 3 configurations; its last iterate is used there: world.landmarks = 2 (in "
                          "2 of 20 runs).")));
  sweep.studies[2].statistics.not_converged = {{.run = 0, .steps = 6}};
  EXPECT_THAT(said(), testing::ElementsAre(testing::HasSubstr("; world.landmarks = 3 (in 1 of 20 runs).")));
}

}  // namespace
}  // namespace credence::internal
