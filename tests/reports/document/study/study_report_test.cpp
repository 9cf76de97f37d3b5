#include "reports/document/study/study_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/study_json.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

ReportedStudy monobot_study(const std::string& name, bool traced = true) {
  Scenario scenario = default_scenario("monobot");
  scenario.name = name;
  scenario.study = {.runs = 20, .steps = 8};
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  ReportedStudy study{
      .analysis = analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {}).front()))};
  if (traced) study.trace = experiment->trace(0);
  return study;
}

ReportedStudy with_verdict(ReportedStudy study, Verdict verdict) {
  study.analysis.word = {
      .verdict = verdict, .p_value = 1e-9, .says = std::string(to_string(verdict)), .joined = {}};
  return study;
}

std::vector<std::string> open_sections(const Document& document) {
  std::vector<std::string> open;
  for (const DocumentPart& part : document.parts()) {
    const auto* fold = std::get_if<part::Fold>(&part);
    if (fold != nullptr && fold->section && fold->open) open.push_back(fold->heading.title);
  }
  return open;
}

TEST(StudyDocument, SaysTheSameOnATerminalOnThePageAndAsData) {
  const TemporaryFolder folder;
  const Document document = study_document({with_verdict(monobot_study("loop"), Verdict::optimistic)});
  const std::string answer = "This filter cannot be trusted: loop is optimistic";
  EXPECT_THAT(document.answer.text, HasSubstr(answer));
  EXPECT_THAT(text_page(document), HasSubstr(answer));
  EXPECT_EQ(nlohmann::json::parse(document.json())["verdict"], "optimistic");
  write_document(document, folder.path(), {});
  EXPECT_THAT(folder.read("index.html"), HasSubstr(answer));
}

// A verdict is of the steps before a run failed.
TEST(StudyDocument, RunsThatFailedAreInTheAnswer) {
  ReportedStudy study = with_verdict(monobot_study("loop"), Verdict::consistent);
  EXPECT_EQ(study_document({study}).answer.tone, CellTone::good);
  StudyStatistics& s = study.analysis.statistics;
  s.failures.push_back({.run = 3, .step = 2, .outcome = Outcome::diverged});
  EXPECT_EQ(study_document({study}).answer.text,
            "No evidence that this covariance is wrong; 1 of 20 runs failed");
  EXPECT_EQ(study_document({study}).answer.tone, CellTone::caution);
  const ReportAnswer unsafe = study_document({with_verdict(study, Verdict::optimistic)}).answer;
  EXPECT_THAT(unsafe.text, HasSubstr("cannot be trusted"));
  EXPECT_THAT(unsafe.text, HasSubstr("; 1 of 20 runs failed"));
  EXPECT_EQ(unsafe.tone, CellTone::alarm);
  s.failures.resize(20, s.failures.front());
  EXPECT_EQ(study_document({study}).answer.text, "No run finished: all 20 failed");
  EXPECT_EQ(study_document({study}).answer.tone, CellTone::alarm);
  s.failures.resize(1);
  s.runs = 1;
  EXPECT_EQ(study_document({study}).answer.text, "The only run failed");
  const TemporaryFolder folder;
  write_document(study_document({study}), folder.path(), {});
  EXPECT_THAT(folder.read("index.html"),
              HasSubstr("The only run failed. It counts up to the step before. It can be replayed alone"));
}

TEST(StudyDocument, NamesWhatIsTooLarge) {
  ReportedStudy study = with_verdict(monobot_study("loop"), Verdict::pessimistic);
  EXPECT_THAT(study_document({study}).answer.text, HasSubstr("This covariance is larger than the errors"));
  study.analysis.word.of_S_alone = true;
  EXPECT_THAT(study_document({study}).answer.text,
              HasSubstr("The innovation covariance S is larger than the innovations"));
}

TEST(StudyDocument, HasEveryStepAndEveryStepOfItsRunBesideThePage) {
  const TemporaryFolder folder;
  write_document(study_document({monobot_study("my loop")}), folder.path(), {});
  const std::string page = folder.read("index.html");
  for (const char* name : {"my_loop.csv", "my_loop-run.csv"}) {
    EXPECT_THAT(page, HasSubstr(fmt::format("href=\"{}\"", name)));
  }
  EXPECT_EQ(std::ranges::count(folder.read("my_loop.csv"), '\n'), 1 + 8);
  EXPECT_EQ(std::ranges::count(folder.read("my_loop-run.csv"), '\n'), 1 + 9) << "the start is a step";
}

TEST(StudyDocument, TheRunThatIsDrawnIsOneThatTheTextNames) {
  ReportedStudy study = monobot_study("loop");
  const auto paragraphs = [&study] {
    std::string text;
    study.trace->run = run_to_draw(study.analysis);
    const Document document = study_document({study});
    for (const DocumentPart& part : document.parts()) {
      if (const auto* paragraph = std::get_if<part::Paragraph>(&part)) text += paragraph->text;
    }
    return text;
  };
  EXPECT_EQ(run_to_draw(study.analysis), 0);
  EXPECT_THAT(paragraphs(), Not(HasSubstr("is drawn")));
  study.analysis.statistics.failures.push_back({.run = 2, .step = 1, .outcome = Outcome::diverged});
  EXPECT_EQ(run_to_draw(study.analysis), 0) << "there is nothing to draw";
  study.analysis.statistics.failures.push_back({.run = 3, .step = 2, .outcome = Outcome::diverged});
  EXPECT_EQ(run_to_draw(study.analysis), 3);
  EXPECT_THAT(paragraphs(), HasSubstr("Run 3 is drawn, which failed."));
  study.analysis.judgement.emplace().lost.runs = {{.run = 7, .row = 2, .factor = 20.0}};
  EXPECT_EQ(run_to_draw(study.analysis), 7);
  EXPECT_THAT(paragraphs(), HasSubstr("Run 7 is drawn, which left P behind."));
}

TEST(StudyDocument, AColumnOfPosesIsThereWhereOneHasAPose) {
  const auto has_column = [](const std::vector<ReportedStudy>& studies) {
    return text_page(study_document(studies)).find("of the pose") != std::string::npos;
  };
  ReportedStudy planar = monobot_study("b");
  planar.analysis.vehicle_nees = planar.analysis.nees;
  EXPECT_FALSE(has_column({monobot_study("a")}));
  EXPECT_TRUE(has_column({monobot_study("a"), planar}));
}

TEST(StudyDocument, SaysHowManyOfTheStatesAreJudged) {
  const auto state_of = [](const ReportedStudy& study) {
    std::string text;
    const Document document = study_document({study});
    for (const DocumentPart& part : document.parts()) {
      const auto* facts = std::get_if<part::Facts>(&part);
      if (facts != nullptr) text = facts->names_and_values.back().second;
    }
    return text;
  };
  ReportedStudy study = monobot_study("loop");
  EXPECT_EQ(state_of(study), "3 dimensions judged");
  study.analysis.state_dim = 15;
  EXPECT_EQ(state_of(study), "3 judged of 15 dimensions");
}

TEST(StudyDocument, WithoutARunItSaysNothingOfOne) {
  const TemporaryFolder folder;
  write_document(study_document({monobot_study("loop", false)}), folder.path(), {});
  EXPECT_THAT(folder.read("index.html"), Not(HasSubstr("loop-run")));
  EXPECT_FALSE(std::filesystem::exists(folder / "loop-run.csv"));
}

TEST(StudyDocument, StudiesOfOneNameHaveFilesAndSectionsOfTheirOwn) {
  const TemporaryFolder folder;
  const Document document = study_document({monobot_study("loop"), monobot_study("loop")});
  write_document(document, folder.path(), {});
  for (const char* name : {"loop.csv", "loop-2.csv", "loop-run.csv", "loop-2-run.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  }
  const std::string page = folder.read("index.html");
  for (const char* anchor : {"loop", "loop-2"}) {
    EXPECT_THAT(page, HasSubstr(fmt::format("<td><a href=\"#{}\">loop</a></td>", anchor)));
    EXPECT_THAT(page, HasSubstr(fmt::format("<details class=\"section\" id=\"{}\"", anchor)));
  }
  EXPECT_EQ(nlohmann::json::parse(document.json())["studies"].size(), 2U);
}

TEST(StudyDocument, AStudyNamedAsTheRunOfAnotherHasAFileOfItsOwn) {
  const TemporaryFolder folder;
  write_document(study_document({monobot_study("loop"), monobot_study("loop-run")}), folder.path(), {});
  EXPECT_EQ(std::ranges::count(folder.read("loop-run.csv"), '\n'), 1 + 9)
      << "the run of loop, with its start";
  EXPECT_EQ(std::ranges::count(folder.read("loop-run-2.csv"), '\n'), 1 + 8);
}

TEST(StudyDocument, OfManyTheFirstThatCannotBeTrustedIsUnfolded) {
  const ReportedStudy a = with_verdict(monobot_study("a"), Verdict::pessimistic),
                      b = with_verdict(monobot_study("b"), Verdict::mixed),
                      c = with_verdict(monobot_study("c"), Verdict::optimistic);
  EXPECT_THAT(open_sections(study_document({a, b})), testing::ElementsAre("a", "b"));
  EXPECT_THAT(open_sections(study_document({a, b, c})), testing::ElementsAre("b"));
  EXPECT_THAT(study_document({a, b, c}).answer.text, HasSubstr("2 of 3 filters cannot be trusted"));
  EXPECT_EQ(study_document({a, b, c}).answer.tone, CellTone::alarm);
}

TEST(StudyDocument, NamesTheFirstFailuresAndCountsTheRest) {
  ReportedStudy study = monobot_study("loop");
  for (std::int64_t run = 0; run < 23; ++run) {
    study.analysis.statistics.failures.push_back({run, 3, Outcome::diverged});
  }
  const TemporaryFolder folder;
  write_document(study_document({study}), folder.path(), {});
  const std::string page = folder.read("index.html");
  EXPECT_THAT(page, HasSubstr("23 of 20 runs failed. They count up to the step before. Each can be"));
  EXPECT_THAT(page, HasSubstr("run 19 at step 3: diverged"));
  EXPECT_THAT(page, Not(HasSubstr("run 20 at step 3")));
  EXPECT_THAT(page, HasSubstr("and 3 more"));
}

TEST(StudyDocument, OfSeveralStudiesSaysWhichCovarianceIsTooLarge) {
  const ReportedStudy large_P = with_verdict(monobot_study("first"), Verdict::pessimistic);
  ReportedStudy large_S = with_verdict(monobot_study("second"), Verdict::pessimistic);
  large_S.analysis.word.of_S_alone = true;
  const std::string none = "No evidence that any of these 2 covariances is too small";
  EXPECT_EQ(study_document({large_P, large_S}).answer.text,
            none + "; larger than necessary: first; S alone larger than necessary: second");
  const ReportAnswer of_S = study_document({large_S, large_S}).answer;
  EXPECT_EQ(of_S.text, none + "; S alone larger than necessary: second, second");
  EXPECT_EQ(of_S.tone, CellTone::caution);
}

TEST(StudyDocument, SaysWhereAnIterationDidNotSettle) {
  ReportedStudy study = monobot_study("loop");
  EXPECT_TRUE(study_json(study.analysis)["outcomes"]["not_converged"].empty());
  for (std::int64_t run = 1; run < 7; ++run) {
    study.analysis.statistics.not_converged.push_back({.run = run, .steps = 2});
  }
  const ReportTable table = std::get<ReportTable>(study_document({study}).brief.front());
  EXPECT_THAT(table.notes, Contains(HasSubstr("loop: In 12 steps of 6 of 20 runs (runs 1, 2, 3, 4, 5, …)")));
  const Json outcomes = study_json(study.analysis)["outcomes"];
  EXPECT_EQ(outcomes["not_converged"][5]["run"], 6);
  EXPECT_EQ(outcomes["not_converged"][5]["steps"], 2);
}

TEST(StudyJson, CountsEveryOutcome) {
  ReportedStudy study = monobot_study("loop");
  study.analysis.statistics.failures.push_back({.run = 1, .step = 2, .outcome = Outcome::threw});
  const Json outcomes = study_json(study.analysis)["outcomes"];
  EXPECT_EQ(outcomes["ok"], 19);
  EXPECT_EQ(outcomes["threw"], 1);
  for (const Outcome outcome : kOutcomes) EXPECT_TRUE(outcomes.contains(std::string(to_string(outcome))));
}

}  // namespace
}  // namespace credence::internal
