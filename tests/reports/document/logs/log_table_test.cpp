#include "reports/document/logs/log_table.h"

#include <gmock/gmock.h>

#include <string>

namespace credence::internal {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

ConsistencyVerdict verdict_of(double mean, Verdict verdict = Verdict::consistent) {
  ConsistencyVerdict v;
  v.verdict = verdict;
  v.mean = mean;
  v.expected = 2.0;
  v.bounds.lower = 1.5;
  v.bounds.upper = 2.5;
  v.p_value = 0.25;
  v.count = 30;
  return v;
}

/// A log with a truth, with these blocks, the mean NEES of which are 1, 2, ….
CheckedLogs logs_with(const std::vector<std::pair<std::string, Part>>& blocks = {}) {
  CheckedLogs logs;
  logs.format = "CSV";
  logs.analysis.evidence.has_truth = true;
  logs.analysis.evidence.rows = 30;
  logs.analysis.evidence.study.runs = 1;
  logs.analysis.judgement.word.verdict = Verdict::consistent;
  logs.analysis.judgement.nees = verdict_of(2.25);
  for (const auto& [name, part] : blocks) {
    BlockSums& sums = logs.analysis.evidence.blocks.emplace_back();
    sums.name = name;
    sums.part = part;
    logs.analysis.judgement.blocks.push_back(
        {name, verdict_of(static_cast<double>(logs.analysis.evidence.blocks.size()))});
  }
  return logs;
}

std::vector<std::string> row_titles(const ReportTable& table) {
  std::vector<std::string> titles;
  for (const auto& row : table.rows) titles.push_back(row.front().text);
  return titles;
}

TEST(LogTable, ThePoseStandsFirstThenItsPartsThenTheOrderOfTheLog) {
  const CheckedLogs logs = logs_with({{"bias", Part::other},
                                      {"heading", Part::heading},
                                      {"position", Part::position},
                                      {"map", Part::map},
                                      {"pose", Part::pose}});
  EXPECT_THAT(row_titles(log_verdicts(logs, 9)),
              ElementsAre("NEES", "NEES of pose", "NEES of position", "NEES of heading", "NEES of bias",
                          "NEES of map"));
  const ReportTable three = log_verdicts(logs, 3);
  EXPECT_THAT(row_titles(three), ElementsAre("NEES", "NEES of pose", "NEES of position", "NEES of heading"));
  EXPECT_THAT(three.notes, Contains("2 more blocks are in the JSON and on the page."));
  EXPECT_EQ(three.rows[1][2].text, "5.000") << "each with its own numbers";
}

TEST(LogTable, AShortTableHasTheBlockThatTheAnswerNames) {
  CheckedLogs logs = logs_with({{"pose", Part::pose}, {"a", Part::other}, {"map", Part::map}});
  logs.analysis.judgement.blocks[1].verdict = verdict_of(9.0, Verdict::optimistic);
  logs.analysis.judgement.word.verdict = Verdict::optimistic;
  logs.analysis.judgement.word.named = {"map"};
  EXPECT_THAT(row_titles(log_verdicts(logs, 2)), ElementsAre("NEES", "NEES of pose", "NEES of map"));
}

TEST(LogTable, ARowHasVerdictMeanBoundsAndCount) {
  CheckedLogs logs = logs_with();
  logs.analysis.judgement.nis = verdict_of(2.75, Verdict::optimistic);
  logs.analysis.judgement.sensors.resize(2);
  logs.analysis.judgement.sensors[0].name = "gps";  // without a value: no row
  logs.analysis.judgement.sensors[1].name = "baro";
  logs.analysis.judgement.sensors[1].nis = verdict_of(1.75);
  const ReportTable table = log_verdicts(logs, 9);
  EXPECT_THAT(row_titles(table), ElementsAre("NEES", "NIS", "NIS of baro"));
  std::vector<std::string> texts;
  for (const TableCell& cell : table.rows.at(1)) texts.push_back(cell.text);
  EXPECT_THAT(texts, ElementsAre("NIS", "optimistic", "2.750", "2.000", "1.500 … 2.500", "0.250", "30"));
  EXPECT_EQ(table.rows[1][1].tone, CellTone::alarm);
  logs.analysis.judgement.sensors.resize(1);
  EXPECT_THAT(row_titles(log_verdicts(logs, 9)), ElementsAre("NEES", "NIS")) << "the only sensor is all";
  logs.analysis.judgement.nis.verdict = Verdict::undecided;
  EXPECT_EQ(log_verdicts(logs, 9).rows[1][5].text, "–") << "as among all tests";
}

TEST(LogTable, TheAnswerSaysHowFarItReaches) {
  CheckedLogs logs = logs_with();
  const std::string asked = "Can this covariance be trusted? ";
  EXPECT_EQ(log_answer(logs), asked + "Yes, nothing speaks against it: consistent");
  SettlingRuns& settle = logs.analysis.judgement.settle_nees;
  settle = {.runs = 40, .detectable = {.below = 0.7, .above = 1.45}};
  EXPECT_EQ(log_answer(logs), asked + "Yes, nothing speaks against it: consistent");
  settle.detectable.above = 2.2;
  EXPECT_EQ(log_answer(logs), asked +
                                  "Yes, nothing speaks against it: consistent; the data are too few to "
                                  "reveal P too small by less than 120 %");
  logs.analysis.evidence.has_truth = false;
  EXPECT_THAT(log_answer(logs), HasSubstr("Yes, as far as innovations can tell: consistent;"));
  Judgement& judgement = logs.analysis.judgement;
  judgement.word.verdict = Verdict::undecided;
  EXPECT_EQ(log_answer(logs), asked + "Undecided");
  judgement.nees.count = 0;
  judgement.nees.reason = "no data";
  EXPECT_EQ(log_answer(logs), asked +
                                  "Undecided: there is no truth to compare with, and there are no "
                                  "innovations; nothing is judged");
  logs.analysis.evidence.has_truth = true;
  EXPECT_THAT(log_answer(logs),
              HasSubstr("Undecided: no row has an error with a variance, and there are no "));
  logs.analysis.evidence.has_truth = false;
  logs.analysis.evidence.rejected["P is not symmetric"] = {.count = 3, .first = "a.csv:7"};
  EXPECT_EQ(log_answer(logs), asked + "Undecided: no data") << "they were there";
  judgement.nees.count = 30;
  judgement.nees.reason = "one run is too short";
  EXPECT_EQ(log_answer(logs), asked + "Undecided: one run is too short");
  judgement.word.verdict = Verdict::optimistic;
  judgement.word.says = "optimistic in yaw";
  judgement.nees.factor.reason = "one run";
  EXPECT_EQ(log_answer(logs), asked + "No: optimistic in yaw");
  judgement.word.verdict = Verdict::mixed;
  judgement.word.says = "optimistic in yaw; pessimistic in x";
  EXPECT_EQ(log_answer(logs), asked + "No: mixed: optimistic in yaw; pessimistic in x");
  judgement.word.verdict = Verdict::pessimistic;
  judgement.word.says = "pessimistic in x";
  EXPECT_EQ(log_answer(logs), asked + "It is larger than the innovations say: pessimistic in x");
  logs.analysis.evidence.has_truth = true;
  EXPECT_EQ(log_answer(logs), asked + "Yes, but it is larger than the errors: pessimistic in x");
  judgement.word.of_S_alone = true;
  EXPECT_EQ(log_answer(logs), asked + "S is larger than the innovations: pessimistic in x");
  judgement.word.verdict = Verdict::not_gaussian;
  judgement.word.says = "the covariance is right";
  EXPECT_EQ(log_answer(logs), asked + "Yes: the covariance is right");
}

// `run` says so too.
TEST(LogTable, TheAnswerHasTheRunsThatFailed) {
  CheckedLogs logs = logs_with();
  Judgement& judgement = logs.analysis.judgement;
  judgement.word.verdict = Verdict::optimistic;
  judgement.word.says = "optimistic in yaw";
  judgement.nees.factor.reason = "one run";
  StudyStatistics& s = logs.analysis.evidence.study;
  s.runs = 6;
  s.failures = {{.run = 0, .step = 54, .outcome = Outcome::diverged},
                {.run = 2, .step = 59, .outcome = Outcome::diverged}};
  EXPECT_THAT(log_answer(logs), EndsWith("No: optimistic in yaw; 2 of 6 runs failed"));
  judgement.word.verdict = Verdict::undecided;
  judgement.word.says = "2 of 6 runs failed, and the others do not speak for them";
  EXPECT_THAT(log_answer(logs), EndsWith("Undecided: " + judgement.word.says)) << "once is enough";
}

TEST(LogTable, ARowThatRejectsBesideAnAnswerThatDoesNotIsExplained) {
  CheckedLogs logs = logs_with({{"pos", Part::other}});
  const auto explained = Contains(HasSubstr("Each row is judged by itself at 5 %"));
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained));
  logs.analysis.judgement.blocks[0].verdict.verdict = Verdict::optimistic;
  EXPECT_THAT(log_verdicts(logs, 9).notes, explained);
  logs.analysis.judgement.word.verdict = Verdict::optimistic;
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained));
  logs.analysis.judgement.word.verdict = Verdict::pessimistic;
  EXPECT_THAT(log_verdicts(logs, 9).notes, explained) << "the other way round";
  logs.analysis.judgement.word.verdict = Verdict::mixed;
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained));
  logs.analysis.judgement.word.verdict = Verdict::not_gaussian;
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained)) << "has a note of its own";
}

TEST(LogTable, ARowThatFailsAloneAmongAllTestsIsExplained) {
  CheckedLogs logs = logs_with({{"pos", Part::other}});
  Judgement& j = logs.analysis.judgement;
  j.word.verdict = j.blocks[0].verdict.verdict = Verdict::optimistic;
  j.tests = {{"NEES of pos", Exactness::conservative, 0.01, 0.02, ""}};
  const auto explained = Contains(EndsWith("and neither is a row that “fails alone” among all tests."));
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained));
  j.tests[0].adjusted = 0.2;
  EXPECT_THAT(log_verdicts(logs, 9).notes, explained);
}

TEST(LogTable, TheIntervalOfAStepThatDecidedIsExplained) {
  CheckedLogs logs = logs_with();
  const auto explained = Contains(HasSubstr("The column “mean” is over all steps; runs"));
  ConsistencyVerdict& nees = logs.analysis.judgement.nees;
  nees = verdict_of(2.25, Verdict::optimistic);
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(explained));
  nees.decided_by_steps = true;
  nees.steps = {{.mean = 9.0, .simultaneous_lower = 0.5, .simultaneous_upper = 7.5}};
  nees.worst_step = 0;
  EXPECT_THAT(log_verdicts(logs, 9).notes, explained);
}

TEST(LogTable, NotesCountWhatWasReadRejectedAndFailed) {
  CheckedLogs logs = logs_with();
  logs.files = 2;
  logs.unmatched_rows = 4;
  logs.analysis.complete = false;
  logs.analysis.evidence.step_stride = 2;
  logs.analysis.evidence.rejected["P is not symmetric"] = {.count = 3, .first = "a.csv:7"};
  logs.analysis.evidence.wrongly_certain["z"] = {.count = 4, .first = "a.csv:2"};
  for (std::int64_t run = 0; run < 2; ++run) {
    logs.analysis.evidence.study.failures.push_back(
        {.run = run, .step = 9, .outcome = Outcome::not_positive_definite});
  }
  logs.failures_said[1] = "singular";
  const std::string failed(to_string(Outcome::not_positive_definite));
  const std::vector<std::string> notes = log_verdicts(logs, 9).notes;
  EXPECT_EQ(notes.front(), "30 rows of 1 run in 2 files (CSV). Interrupted.");
  EXPECT_THAT(notes, Contains(HasSubstr("of every 2nd step")));
  EXPECT_THAT(notes,
              Contains(HasSubstr("LEFT OUT: z in 4 rows, where P claims certainty (variance 0) and it errs "
                                 "(first: a.csv:2)")));
  EXPECT_THAT(notes, Contains("No truth at their time, and left out: 4 rows."));
  EXPECT_THAT(notes, Contains("REJECTED: 3 rows, P is not symmetric (first: a.csv:7)."));
  EXPECT_THAT(notes, Contains("FAILED: run 0, " + failed + " at step 9."));
  EXPECT_THAT(notes, Contains("FAILED: run 1, " + failed + " at step 9: singular."));
  logs.run_names = {"run 7 of a.csv", "run 9 of a.csv"};
  EXPECT_THAT(log_verdicts(logs, 9).notes,
              Contains("FAILED: run 9 of a.csv, " + failed + " at step 9: singular."));
  // More than five: the first, and how many.
  logs.analysis.evidence.study.failures.resize(6);
  const std::vector<std::string> many = log_verdicts(logs, 9).notes;
  EXPECT_THAT(many, Contains("… 6 runs failed in all."));
  EXPECT_THAT(many, Contains(HasSubstr("FAILED: run 7 of a.csv")));
  EXPECT_THAT(many, Not(Contains(HasSubstr("FAILED: run 9"))));
}

TEST(LogTable, StatisticsNameASensorUnlessItIsTheOnlyOne) {
  Judgement judgement;
  judgement.sensors.resize(2);
  judgement.sensors[0].whiteness.p_value = 0.5;
  judgement.sensors[0].mean.reason = "too few values";
  judgement.sensors[0].fit.reason = "no law";
  judgement.sensors[1].name = "gps";
  judgement.sensors[1].fit.reason = "not tested: many values are equal";
  const std::vector<std::string> said = log_statistics(judgement);
  EXPECT_EQ(said.at(0), "innovation: test of whiteness in time p = 0.500; of mean zero: too few values.");
  EXPECT_THAT(said, Contains("NIS of gps against its chi-square law: not tested: many values are equal."));
  EXPECT_THAT(said, Not(Contains(HasSubstr("no law"))));
}

TEST(LogTable, SaysThatAVehicleIsNoPose) {
  CheckedLogs logs = logs_with();
  EXPECT_EQ(logs.all_remarks(), logs.remarks);
  logs.analysis.evidence.layout.states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  logs.analysis.evidence.layout.angles = {false, false, false};
  EXPECT_THAT(log_verdicts(logs, 9).notes, Contains(HasSubstr("vehicle.… are 3 states, 0 of them angles")));
}

// No row of the table says what the answer does.
TEST(LogTable, ExplainsWhatIsSoAtSomeTimes) {
  CheckedLogs logs = logs_with();
  EXPECT_THAT(log_verdicts(logs, 9).notes, Not(Contains(HasSubstr("At some times"))));
  Judgement& j = logs.analysis.judgement;
  j.nees_over_time = {{{.p_value = 1e-5, .wave = 187.0}, ""}, {{.p_value = 0.25, .wave = 20.0}, "vehicle"}};
  j.sensors.resize(1);
  j.sensors[0].name = "gps";
  j.sensors[0].over_time = {.p_value = 0.001, .wave = 250.0};
  j.word.named = {"NEES at some times", "NIS of gps at others"};
  const std::vector<std::string> notes = log_verdicts(logs, 9).notes;
  EXPECT_THAT(notes,
              Contains("At some times, at others: NEES goes up and down in time by more than the memory "
                       "of the errors makes (p = 1.00e−5), most in waves of about 187 rows. Its mean "
                       "may be right all the same."));
  EXPECT_THAT(
      notes,
      Contains("At some times, at others: NIS of gps goes up and down in time (p = 0.00100), most in waves "
               "of about 250 steps. Its mean may be right all the same."));
  EXPECT_THAT(notes, Not(Contains(HasSubstr("NEES of vehicle goes"))));
  EXPECT_THAT(log_statistics(j),
              Contains("Test whether NEES changes in time, beyond what the memory of the errors makes: p "
                       "= 1.00e−5, of vehicle p = 0.250."));
  j.word.named = {"vehicle at some times"};
  EXPECT_THAT(log_verdicts(logs, 9).notes,
              Contains(HasSubstr("At some times, at others: NEES of vehicle goes up and down in time")));
}

TEST(LogTable, ATinyPValueIsNoEquation) {
  Judgement judgement;
  judgement.sensors.resize(1);
  judgement.sensors[0].name = "gps";
  judgement.sensors[0].whiteness.p_value = 1e-20;
  judgement.sensors[0].mean.p_value = 0.25;
  EXPECT_THAT(log_statistics(judgement),
              Contains("gps: test of whiteness in time p < 1e−12; of mean zero p = 0.250."));
  judgement.sensors[0].over_time.p_value = 1e-20;
  EXPECT_THAT(log_statistics(judgement),
              Contains(EndsWith("; of NIS that goes up and down in time p < 1e−12.")));
}

}  // namespace
}  // namespace credence::internal
