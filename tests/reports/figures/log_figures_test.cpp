#include "reports/figures/log_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "tests/reports/document/synthetic_logs.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

/// The consistency, the errors and the blocks of logs.
Figure log_figure(const CheckedLogs& logs, const std::string& end) {
  for (const Figure& figure : log_figures("mine", logs)) {
    if (figure.name == "mine-" + end) return figure;
  }
  throw std::out_of_range(end);
}

std::vector<std::string> panel_titles(const Figure& figure) {
  std::vector<std::string> titles;
  for (const Panel& panel : figure.panels) titles.push_back(panel.title.text);
  return titles;
}

TEST(LogFigures, HaveNeesAndNisOfTheJudgement) {
  const CheckedLogs logs = synthetic_logs(Defect::none);
  const Figure figure = log_figure(logs, "consistency");
  EXPECT_NO_THROW(validate(figure));
  EXPECT_THAT(panel_titles(figure), ElementsAre("NEES", "NIS"));
  EXPECT_EQ(figure.cols, 2);
  EXPECT_THAT(figure.caption, HasSubstr("NEES and NIS, means over 32 runs"));
  EXPECT_THAT(figure.caption, HasSubstr("at 95 % of single steps"));
  bool found = false;
  for (const Series& series : figure.panels[0].series) {
    if (series.label.text != "measured mean") continue;
    found = true;
    ASSERT_EQ(series.y.size(), 40U);
    EXPECT_EQ(series.y[7], logs.analysis.judgement.nees.steps[7].mean);
  }
  EXPECT_TRUE(found);
}

TEST(LogFigures, EverySensorHasItsOwnPanelOfNis) {
  const CheckedLogs logs = synthetic_logs(Defect::shared_prior);
  const Figure figure = log_figure(logs, "consistency");
  EXPECT_NO_THROW(validate(figure));
  EXPECT_THAT(panel_titles(figure), ElementsAre("NEES", "NIS of landmark", "NIS of compass"));
  EXPECT_EQ(figure.panels[2].series.back().y[7], logs.analysis.judgement.sensors[1].nis.steps[7].mean);
}

TEST(LogFigures, OfWhatLogsDoNotHoldThereIsNoPanel) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  logs.analysis.judgement.nees.count = 0;
  EXPECT_THAT(panel_titles(log_figure(logs, "consistency")), ElementsAre("NIS"));
  EXPECT_THAT(log_figure(logs, "consistency").caption, ::testing::StartsWith("NIS, "));
  for (const Figure& figure : log_figures("none", {})) EXPECT_TRUE(figure.panels.empty()) << figure.name;
}

RunErrors errors_of(std::size_t states) {
  RunErrors run;
  run.step = {1.0, 2.0, 3.0};
  for (std::size_t i = 0; i < states; ++i) {
    run.states.push_back(
        {.name = "x" + std::to_string(i), .error = {0.5, -0.25, 1.0}, .sigma = {0.25, 0.5, 0.75}});
  }
  return run;
}

TEST(LogFigures, ErrorsHaveTwoSigmaAboutThemAndAnglesAreInDegrees) {
  CheckedLogs logs;
  logs.first_run = errors_of(2);
  logs.first_run.states[1].unit = "rad";
  const Figure figure = log_figure(logs, "errors");
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  const std::vector<Series>& x = figure.panels[0].series;
  EXPECT_THAT(x.at(2).x, ElementsAre(1.0, 2.0, 3.0));
  EXPECT_THAT(x.at(2).y, ElementsAre(0.5, -0.25, 1.0));
  EXPECT_THAT(x.at(0).y, ElementsAre(-0.5, -1.0, -1.5));
  EXPECT_THAT(x.at(1).y, ElementsAre(0.5, 1.0, 1.5));
  EXPECT_EQ(figure.panels[0].y_label.text, "error");
  EXPECT_EQ(figure.panels[1].y_label.text, "error (°)");
  EXPECT_NEAR(figure.panels[1].series.at(2).y[2], 180.0 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(figure.panels[1].series.at(1).y[0], 0.5 * 180.0 / std::numbers::pi, 1e-12);
}

TEST(LogFigures, WithTimesTheyAreOverTimeAndPositionsAreInMetres) {
  CheckedLogs logs;
  logs.first_run = errors_of(2);
  RunLayout& layout = logs.analysis.evidence.layout;
  layout.states = {"x0", "x1"};
  layout.blocks = {{"position", Part::position, {0}}};
  logs.first_run.states[1].unit = "m";
  const auto times = std::make_shared<StepTimes>();
  for (int k = 1; k <= 3; ++k) times->add(k, 0.5 * k);
  ConsistencyVerdict& nees = logs.analysis.judgement.nees;
  nees.times = times;
  nees.count = 3;
  nees.steps.assign(3, {.mean = 1.0, .expected = 1.0, .count = 1, .total_dof = 1.0});
  const Figure errors = log_figure(logs, "errors"), consistency = log_figure(logs, "consistency");
  EXPECT_EQ(errors.panels.at(0).x_label.text, "time (s)");
  EXPECT_THAT(errors.panels[0].series.at(2).x, ElementsAre(0.5, 1.0, 1.5));
  EXPECT_EQ(errors.panels[0].y_label.text, "error") << "a position of no known unit";
  EXPECT_EQ(errors.panels.at(1).y_label.text, "error (m)");
  EXPECT_EQ(consistency.panels.at(0).x_label.text, "time (s)");
  EXPECT_THAT(consistency.panels[0].series.back().x, ElementsAre(0.5, 1.0, 1.5));
}

TEST(LogFigures, OfManyStatesThoseThatAreEstimatedAmongTheFirst) {
  CheckedLogs logs;
  logs.analysis.evidence.layout.states.resize(18);
  logs.first_run = errors_of(8);
  for (const std::size_t i : {1U, 3U}) logs.first_run.states[i].error = {kAbsent, kAbsent, kAbsent};
  logs.first_run.states[4].error[0] = kAbsent;  // not there yet
  const Figure figure = log_figure(logs, "errors");
  EXPECT_THAT(panel_titles(figure), ElementsAre("x0", "x2", "x4", "x5", "x6", "x7"));
  EXPECT_EQ(figure.rows, 2);
  EXPECT_EQ(figure.cols, 3);
  EXPECT_THAT(figure.caption, HasSubstr("errors of the first 8 of 18 states"));
  logs.analysis.evidence.layout.states.resize(15);
  logs.first_run = errors_of(15);  // position, velocity, attitude and two biases
  EXPECT_EQ(log_figure(logs, "errors").panels.size(), 15U);
  EXPECT_EQ(log_figure(logs, "errors").rows, 5);
  logs.analysis.evidence.layout.states.resize(4);
  logs.first_run = errors_of(4);
  EXPECT_THAT(log_figure(logs, "errors").caption, Not(HasSubstr("of the first")));
  EXPECT_EQ(log_figure(logs, "errors").rows, 2);
}

/// A block with a verdict of one step.
void add_log_block(LogAnalysis& analysis, const std::string& name, Part part, std::int64_t count) {
  BlockSums& sums = analysis.evidence.blocks.emplace_back();
  sums.name = name;
  sums.part = part;
  ConsistencyVerdict verdict;
  verdict.verdict = Verdict::consistent;
  verdict.count = count;
  verdict.steps = {{.mean = 1.0, .expected = 1.0, .lower = 0.5, .upper = 1.5, .count = count}};
  analysis.judgement.blocks.push_back({name, verdict});
}

TEST(LogFigures, ThePoseIsTheFirstOfAtMostSixBlocks) {
  CheckedLogs logs;
  add_log_block(logs.analysis, "bias", Part::other, 5);
  add_log_block(logs.analysis, "empty", Part::other, 0);
  add_log_block(logs.analysis, "pose", Part::pose, 5);
  EXPECT_THAT(panel_titles(log_figure(logs, "blocks")), ElementsAre("pose", "bias")) << "none without a row";
  EXPECT_EQ(log_figure(logs, "blocks").cols, 2);
  for (int i = 0; i < 8; ++i) add_log_block(logs.analysis, "b" + std::to_string(i), Part::other, 5);
  const Figure many = log_figure(logs, "blocks");
  EXPECT_THAT(panel_titles(many), ElementsAre("pose", "bias", "b0", "b1", "b2", "b3"));
  EXPECT_THAT(many.caption, HasSubstr("Of 10 blocks 6 are shown, inconsistent ones first."));
  EXPECT_EQ(many.rows, 2);
  const auto judge = [&logs](const char* name, Verdict verdict, double p_value, double mean) {
    auto& blocks = logs.analysis.judgement.blocks;
    ConsistencyVerdict& of = std::ranges::find(blocks, name, &BlockVerdict::name)->verdict;
    of.verdict = verdict;
    of.p_value = p_value;
    of.mean = mean;
    of.expected = 1.0;
    of.dof = 100.0;
  };
  judge("b5", Verdict::optimistic, 0.0, 2.0);
  judge("b6", Verdict::pessimistic, 1e-3, 0.8);
  judge("b7", Verdict::optimistic, 0.0, 3.0);
  judge("pose", Verdict::undecided, 0.02, 1.3);
  EXPECT_THAT(panel_titles(log_figure(logs, "blocks")), ElementsAre("b7", "b5", "b6", "pose", "bias", "b0"));
  EXPECT_EQ(many.cols, 3);
}

TEST(LogFigures, CanAllBeDrawn) {
  CheckedLogs logs = synthetic_logs(Defect::wrong_dof);
  logs.first_run = errors_of(3);
  std::vector<std::string> names;
  for (const Figure& figure : log_figures("mine", logs)) {
    names.push_back(figure.name);
    if (!figure.panels.empty()) EXPECT_NO_THROW(validate(figure)) << figure.name;
  }
  ASSERT_EQ(names.size(), 6U);
  EXPECT_EQ(names[1], "mine-errors") << "the order of the page";
  EXPECT_EQ(names.back(), "mine-blocks");
}

}  // namespace
}  // namespace credence::internal
