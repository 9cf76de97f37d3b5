#include "reports/document/logs/log_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "reports/document/logs/log_json.h"
#include "reports/document/logs/log_table.h"
#include "tests/reports/document/parts_of.h"
#include "tests/reports/document/synthetic_logs.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

std::vector<std::string> sections_of(const Document& document) {
  std::vector<std::string> titles;
  for (const DocumentPart& part : document.parts()) {
    const auto* heading = std::get_if<part::Heading>(&part);
    if (heading != nullptr) titles.push_back(heading->title);
  }
  return titles;
}

std::vector<part::Callout> callouts_of(const Document& document) {
  std::vector<part::Callout> all;
  for (const DocumentPart& part : document.parts()) {
    if (const auto* callout = std::get_if<part::Callout>(&part)) all.push_back(*callout);
  }
  return all;
}

std::vector<std::string> bullets_of(const Document& document) {
  std::vector<std::string> all;
  for (const DocumentPart& part : document.parts()) {
    if (const auto* bullets = std::get_if<part::Bullets>(&part))
      all.insert(all.end(), bullets->items.begin(), bullets->items.end());
  }
  return all;
}

TEST(LogReport, OfAConsistentFilterSaysThatNothingSpeaksAgainstIt) {
  const CheckedLogs logs = synthetic_logs(Defect::none);
  const Document document = log_document(logs);
  EXPECT_EQ(document.title, "my logs");
  EXPECT_EQ(document.answer.text, log_answer(logs));
  EXPECT_THAT(document.answer.text, HasSubstr("Yes, nothing speaks against it: consistent"));
  EXPECT_EQ(document.answer.tone, CellTone::good);
  EXPECT_EQ(document.json(), log_json(logs));
  EXPECT_TRUE(callouts_of(document).empty());
  EXPECT_THAT(sections_of(document), Contains("Factors on P"));
}

TEST(LogReport, OfAWrongFilterSaysWhatToDoAndWhatWouldMendIt) {
  const CheckedLogs logs = synthetic_logs(Defect::measurement_noise_too_small);
  const Document document = log_document(logs);
  EXPECT_EQ(document.answer.tone, CellTone::alarm);
  EXPECT_THAT(document.answer.text, HasSubstr("optimistic"));
  EXPECT_THAT(sections_of(document),
              ElementsAre("Verdicts", "What to do", "Factors on P", "Figures", "Where P lies", "Tests"));
  const std::string cause(to_string(logs.analysis.judgement.causes.at(0).cause));
  EXPECT_THAT(bullets_of(document), Contains(testing::StartsWith("Likely cause: " + cause)));
  EXPECT_THAT(bullets_of(document), Contains(testing::StartsWith("The factor on P is ")));
  EXPECT_THAT(bullets_of(document), Contains(testing::StartsWith("NEES: optimistic.")));
}

TEST(LogReport, WithoutAFigureThereIsNoHeadingOfFigures) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  EXPECT_THAT(sections_of(log_document(logs)), Contains("Figures"));
  Judgement& judgement = logs.analysis.judgement;
  judgement.nees.count = judgement.nis.count = 0;
  judgement.blocks.clear();
  logs.first_run = RunErrors{};
  logs.calibration = {};
  EXPECT_THAT(sections_of(log_document(logs)), Not(Contains("Figures")));
}

TEST(LogReport, BesideAMistakeOfTheLogErrorsTellNoCauseAndNoFactor) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  Judgement& judgement = logs.analysis.judgement;
  judgement.word.verdict = judgement.nees.verdict = Verdict::optimistic;
  judgement.word.says = "optimistic throughout";
  judgement.nees.factor = {.mean = 4.0, .lower = 3.0, .upper = 5.0, .reason = ""};
  const auto found = [](Cause cause) { return CauseFound{cause, "why"}; };
  judgement.causes = {found(Cause::bias), found(Cause::covariance_scale), found(Cause::unwrapped_angle)};
  EXPECT_THAT(log_answer(logs), HasSubstr("scaling P by 4"));
  drop_explained_causes(judgement);
  EXPECT_THAT(judgement.causes, ElementsAre(::testing::Field(&CauseFound::cause, Cause::unwrapped_angle)));
  EXPECT_FALSE(judgement.scale_covariance.reason.empty());
  EXPECT_THAT(log_answer(logs), Not(HasSubstr("scaling P")));
  EXPECT_THAT(logs.factor_sentences(),
              ElementsAre("No factor on P is given: a mistake of what was logged is named."));
  judgement.nis.verdict = Verdict::optimistic;
  judgement.causes = {found(Cause::bias)};
  drop_explained_causes(judgement);
  EXPECT_EQ(judgement.causes.size(), 1U) << "innovations may have told it";
}

// As of an error that a simulation drew once, or of a bias: mean NEES may even be right.
TEST(LogReport, ErrorsOfOneSizeAreSaidToBeNoSample) {
  const auto judged = [](int runs, std::int64_t rows, double change) {
    EvidenceRecorder sums;
    RunLayout layout{.states = {"x", "y"}, .angles = {false, false}};
    add_named_blocks(layout);
    sums.begin_file("one_size.csv", layout);
    for (int run = 0; run < runs; ++run) {
      sums.begin_run();
      for (std::int64_t k = 1; k <= rows; ++k) {
        const double turn = 0.1 * static_cast<double>(k), size = run + 1 == runs && k == rows ? change : 1.0;
        sums.add(Step{.step = k,
                      .states = {0, 1},
                      .error = size * Eigen::Vector2d(std::cos(turn), std::sin(turn)),
                      .P = 0.8 * Matrix::Identity(2, 2)});
      }
      sums.end_run(Outcome::ok, rows);
    }
    CheckedLogs logs;
    judge_collected(sums.take(), {}, {}, {}, logs);
    return logs;
  };
  EXPECT_THAT(judged(2, 10, 1.0).advice(),
              Contains("Every NEES is 1.250: errors of one size are no sample of a covariance; was one error "
                       "drawn for all 20 rows, or are they a bias without noise?"));
  EXPECT_TRUE(judged(2, 10, 1.0).analysis.judgement.causes.empty());
  for (const CheckedLogs& others : {judged(1, 19, 1.0), judged(2, 10, 1.0 + 1e-10), judged(2, 10, 0.0)})
    EXPECT_THAT(others.advice(), Not(Contains(HasSubstr("one size"))));
}

TEST(LogReport, EveryBlockHasARowAndTheTerminalOne) {
  const CheckedLogs logs = synthetic_logs(Defect::none);
  const Document document = log_document(logs);
  const ReportTable verdicts = table_of(document, "each block of states");
  std::vector<std::string> rows;
  for (const auto& row : verdicts.rows) rows.push_back(row.front().text);
  for (const BlockVerdict& block : logs.analysis.judgement.blocks) {
    EXPECT_THAT(rows, Contains("NEES of " + block.name));
  }
  ASSERT_EQ(document.brief.size(), 1U);
  EXPECT_EQ(std::get<ReportTable>(document.brief[0]).rows.size(), log_table(logs).rows.size());
}

TEST(LogReport, RejectedRowsAreAnAlarmWithTheFirstOfEveryKind) {
  CheckedLogs logs;
  logs.analysis.evidence.rows = 30;
  logs.analysis.evidence.rejected["P is not symmetric"] = {.count = 3, .first = "a.csv:7"};
  const Document document = log_document(logs);
  ASSERT_EQ(callouts_of(document).size(), 1U);
  EXPECT_EQ(callouts_of(document)[0].tone, CellTone::alarm);
  EXPECT_THAT(callouts_of(document)[0].text, testing::StartsWith("3 of 30 rows were rejected"));
  EXPECT_THAT(bullets_of(document), Contains("3 rows: P is not symmetric; the first is a.csv:7"));
}

TEST(LogReport, AStateThatErrsWhereItIsKnownIsAnAlarm) {
  CheckedLogs logs;
  logs.analysis.evidence.rows = 30;
  logs.analysis.evidence.wrongly_certain["z"] = {.count = 3, .first = "a.csv:7"};
  const Document document = log_document(logs);
  ASSERT_EQ(callouts_of(document).size(), 1U);
  EXPECT_EQ(callouts_of(document)[0].tone, CellTone::alarm);
  EXPECT_EQ(
      callouts_of(document)[0].text,
      "z errs in 3 of 30 rows where P claims certainty (variance 0), and is left out of them; the first is "
      "a.csv:7.");
}

TEST(LogReport, AnEarlierVersionIsComparedBeforeAnythingElse) {
  CheckedLogs logs;
  logs.gate = LogGate{.baseline = "old.json", .verdict_before = "consistent"};
  EXPECT_EQ(callouts_of(log_document(logs)).at(0).tone, CellTone::caution) << "nothing was compared";
  logs.gate->changes.resize(1);
  EXPECT_EQ(callouts_of(log_document(logs)).at(0).tone, CellTone::good);
  logs.gate->worse = {"it is more optimistic"};
  const part::Callout worse = callouts_of(log_document(logs)).at(0);
  EXPECT_EQ(worse.tone, CellTone::alarm);
  EXPECT_THAT(worse.text, HasSubstr("WORSE: it is more optimistic"));
}

// Of the first file that has charts; a planar pose has none.
TEST(LogReport, ThePoseIsShownInEveryChart) {
  CheckedLogs logs;
  logs.poses.resize(1);
  EXPECT_THAT(sections_of(log_document(logs)), Not(Contains("Charts")));
  logs.poses.push_back(synthetic_poses());
  const Document document = log_document(logs);
  EXPECT_THAT(sections_of(document), Contains("Charts"));
  const ReportTable charts = table_of(document, "in every chart, 6 expected; judged is right");
  ASSERT_EQ(charts.rows.size(), 2U);
  EXPECT_EQ(charts.rows[0][0].text, "left");
  EXPECT_EQ(charts.rows[0][1].text, "9.500");
  EXPECT_EQ(charts.rows[0][3].text, "6.250");
  EXPECT_EQ(charts.rows[1][0].text, "right (judged)");
  EXPECT_EQ(charts.rows[1][2].text, "–") << "not tested";
  EXPECT_THAT(charts.notes.front(), testing::StartsWith("Of run.csv, 100 rows."));
}

TEST(LogReport, EveryStepStandsBesideThePageAsCsv) {
  const TemporaryFolder folder;
  const Document document = log_document(synthetic_logs(Defect::none));
  ASSERT_EQ(document.files.size(), 1U);
  EXPECT_EQ(document.files[0].name, "my_logs.csv");
  document.files[0].write(folder / "steps.csv");
  const std::string text = folder.read("steps.csv");
  EXPECT_EQ(std::ranges::count(text, '\n'), 41) << "a header and 40 steps";
  CheckedLogs nameless;
  EXPECT_EQ(log_document(nameless).files.at(0).name, "logs.csv");
}

TEST(LogReport, LogsWithoutARowHaveAPageToo) {
  const Document document = log_document({});
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  EXPECT_EQ(nlohmann::json::parse(document.json())["verdict"], "undecided");
}

TEST(LogReport, AMistakeOfTheLogIsTheFirstThingToDo) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  logs.mistakes = {"the truth is in another unit"};
  logs.remarks = {"half of it was cut off"};
  EXPECT_EQ(logs.advice().front(), "the truth is in another unit");
  const Document document = log_document(logs);
  const auto bullets = std::ranges::find_if(
      document.parts(), [](const DocumentPart& part) { return std::holds_alternative<part::Bullets>(part); });
  EXPECT_EQ(std::get<part::Bullets>(*bullets).items.front(), "the truth is in another unit");
  const std::vector<std::string> notes = table_of(document, "One row for the whole state").notes;
  EXPECT_THAT(notes, Contains("half of it was cut off"));
  EXPECT_THAT(notes, Not(Contains("the truth is in another unit")));
  EXPECT_EQ(nlohmann::json::parse(document.json())["remarks"],
            nlohmann::json::array({"the truth is in another unit", "half of it was cut off"}));
}

TEST(LogReport, AMisfitIsToldWhereSomeErrorsOfAllRunsMisfit) {
  const auto told = [](Verdict nees, Verdict block, bool lost = false, double factor_of_others = 1.0) {
    Judgement judgement;
    judgement.nees.verdict = nees;
    judgement.blocks.resize(2);
    judgement.blocks[0].verdict.verdict = Verdict::consistent;
    judgement.blocks[1].verdict.verdict = block;
    if (lost) judgement.lost = {.runs = {{.run = 7}}, .factor_of_others = factor_of_others};
    return mistakes_told({.misfits = {"standard deviations"}, .others = {"the unit of time"}}, judgement);
  };
  EXPECT_THAT(told(Verdict::consistent, Verdict::consistent), ElementsAre("the unit of time"));
  for (const auto& [nees, block] : {std::pair(Verdict::consistent, Verdict::pessimistic),
                                    std::pair(Verdict::optimistic, Verdict::consistent),
                                    std::pair(Verdict::undecided, Verdict::undecided)})
    EXPECT_THAT(told(nees, block), ElementsAre("standard deviations", "the unit of time"));
  EXPECT_THAT(told(Verdict::optimistic, Verdict::optimistic, true), ElementsAre("the unit of time"));
  EXPECT_THAT(told(Verdict::optimistic, Verdict::optimistic, true, 1.5), SizeIs(2));
}

TEST(CheckedLogs, OfFewRunsThatArePessimisticItIsSaidWhatTheyCannotTell) {
  CheckedLogs logs;
  const auto last = [&](Verdict verdict, std::int64_t runs) {
    logs.analysis.judgement.word.verdict = verdict;
    logs.analysis.evidence.study.runs = runs;
    return logs.advice().back();
  };
  const auto told = HasSubstr("an error which stays over a run");
  EXPECT_THAT(last(Verdict::pessimistic, 1), told);
  EXPECT_THAT(last(Verdict::pessimistic, 1), HasSubstr("One run cannot tell"));
  EXPECT_THAT(last(Verdict::pessimistic, 4), AllOf(told, HasSubstr("So few runs cannot surely tell")));
  EXPECT_THAT(last(Verdict::pessimistic, 5), Not(told));
  EXPECT_THAT(last(Verdict::optimistic, 1), Not(told));
}

TEST(CheckedLogs, RemarksEndWithWhatTheLayoutMisses) {
  CheckedLogs logs;
  logs.remarks = {"half of it was cut off"};
  EXPECT_THAT(logs.all_remarks(), ElementsAre("half of it was cut off"));
  logs.analysis.evidence.layout.states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  logs.analysis.evidence.layout.angles = {false, false, false};
  EXPECT_THAT(logs.all_remarks(),
              ElementsAre("half of it was cut off", HasSubstr("vehicle.… are 3 states, 0 of them angles")));
}

}  // namespace
}  // namespace credence::internal
