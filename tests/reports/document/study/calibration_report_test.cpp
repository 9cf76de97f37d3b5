#include "reports/document/study/calibration_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

DistanceBin length(double from_m, double adjusted) {
  return {.from_m = from_m,
          .to_m = from_m + 10.0,
          .rows = 50,
          .nees = {.mean = 1.5, .lower = 1.25, .upper = 1.75, .count = 6},
          .p_value = adjusted,
          .adjusted = adjusted};
}

std::string of_lengths(std::vector<DistanceBin> bins) {
  Calibration calibration;
  calibration.distance = std::move(bins);
  const std::vector<std::string> sentences = calibration_sentences(calibration);
  return sentences.empty() ? "" : sentences.back();
}

TEST(CalibrationSentences, TheClearestSignIsOfALengthThatWasTested) {
  EXPECT_THAT(of_lengths({length(0.0, kNaN), length(10.0, 1.0), length(20.0, 1.0)}),
              HasSubstr("The clearest sign that it is not 1: p = 1.00, 10 to 20 m (Holm over 3 lengths)."));
  EXPECT_THAT(of_lengths({length(0.0, 0.5), length(10.0, kNaN), length(20.0, 0.25)}),
              HasSubstr("p = 0.250, 20 to 30 m"));
  EXPECT_THAT(of_lengths({length(0.0, kNaN)}), HasSubstr("There is no test with fewer than five runs."));
  EXPECT_THAT(of_lengths({}), IsEmpty());
}

TEST(CalibrationSentences, ByClaimedSigmaWhatRejectsIsTold) {
  Calibration calibration;
  ClaimedSigmaTest& test = calibration.claimed_sigma;
  EXPECT_THAT(calibration_sentences(calibration), IsEmpty());  // nothing was tested
  test.optimistic = {"vx where its σ is 0.100 to 0.178", 0.001, {.mean = 2.5, .lower = 2.0, .upper = 3.0}};
  test.pessimistic = {"vx where its σ is 1.00 to 1.78", 0.2, {.mean = 0.9, .lower = 0.8, .upper = 1.1}};
  EXPECT_THAT(
      calibration_sentences(calibration),
      ElementsAre("By the σ that is claimed, the factor on σ² is 2.50 (2.00 … 3.00) in vx where its σ "
                  "is 0.100 to 0.178 (p = 0.00100)."));
  test.pessimistic.p_value = 0.04;
  EXPECT_THAT(
      calibration_sentences(calibration)[0],
      HasSubstr("(p = 0.00100), 0.900 (0.800 … 1.10) in vx where its σ is 1.00 to 1.78 (p = 0.0400)."));
}

// As of errors that are all zero: any factor is 0 of 0.
TEST(CalibrationSentences, WhatWasLeftOutIsToldWhereItHasAMean) {
  Calibration calibration;
  calibration.units = "runs";
  calibration.unit_count = 20;
  calibration.whole = {.name = "state", .factor = {.mean = 1.0, .lower = 0.9, .upper = 1.1, .count = 20}};
  calibration.with_factor = calibration.whole.factor;
  EXPECT_THAT(calibration_sentences(calibration)[0], HasSubstr("On runs left out"));
  calibration.parts = {calibration.whole, calibration.whole};
  calibration.with_part_factors = calibration.whole.factor;
  EXPECT_THAT(calibration_sentences(calibration)[0], HasSubstr("; scaled part by part 1.00"));
  calibration.with_part_factors.mean = kNaN;
  EXPECT_THAT(calibration_sentences(calibration)[0], ::testing::Not(HasSubstr("part by part")));
  calibration.with_factor.mean = kNaN;
  EXPECT_THAT(calibration_sentences(calibration)[0], ::testing::Not(HasSubstr("On runs left out")));
}

TEST(UnitFactors, ComeBackFromTheDocumentAsTheyWere) {
  Calibration calibration;
  calibration.units = "runs";
  const UnitFactors units{
      .units = "runs", .names = {"a", "b"}, .parts = {"NEES", "yaw"}, .factors = {{1.5, kNaN}, {0.25, 2.0}}};
  const UnitFactors back = unit_factors_of(calibration_json(calibration, units, {}));
  EXPECT_EQ(back.units, "runs");
  EXPECT_THAT(back.names, ElementsAre("a", "b"));
  EXPECT_THAT(back.parts, ElementsAre("NEES", "yaw"));
  EXPECT_EQ(back.factors[0][0], 1.5);
  EXPECT_TRUE(std::isnan(back.factors[0][1])) << "null";
  EXPECT_THAT(back.factors[1], ElementsAre(0.25, 2.0));
  EXPECT_THAT(unit_factors_of(Json()).names, IsEmpty()) << "of logs without a truth";
}

TEST(SigmaTable, AStateWithoutANameHasItsNumberAndAnUntestedBinNoPValue) {
  Calibration calibration;
  calibration.bins = {{.state = 0, .lower = 1.0, .upper = 2.0, .claimed = 1.5, .rmse = 3.0, .rows = 7},
                      {.state = 4, .lower = 1.0, .upper = 2.0, .claimed = 1.5, .rmse = 3.0, .rows = 7}};
  for (SigmaBin& bin : calibration.bins) bin.p_value = bin.adjusted = kNaN;
  const ReportTable table = sigma_table(calibration, {.states = {"x"}});
  EXPECT_EQ(table.rows.at(0)[0].text, "x");
  EXPECT_EQ(table.rows.at(1)[0].text, "x5");
  EXPECT_EQ(table.rows.at(1)[5].text, "–");
  EXPECT_EQ(table.rows.at(1)[6].text, "–");
}

TEST(SigmaTable, AStateHasTheUnitThatTheLayoutGivesIt) {
  Calibration calibration;
  for (Index state = 0; state < 3; ++state)
    calibration.bins.push_back({.state = state, .claimed = 1.5, .rmse = 3.0, .rows = 7});
  const ReportTable table = sigma_table(
      calibration, {.states = {"v", "yaw", "k"}, .angles = {false, true, false}, .units = {"m/s", "", ""}});
  EXPECT_EQ(table.rows.at(0)[0].text, "v (m/s)");
  EXPECT_EQ(table.rows.at(1)[0].text, "yaw (rad)") << "numbers of this table are as in the log";
  EXPECT_EQ(table.rows.at(2)[0].text, "k");
}

TEST(SigmaFigure, AxesHaveTheUnitOfTheState) {
  Calibration calibration;
  for (const Index state : {Index{0}, Index{0}, Index{1}, Index{1}}) {
    const double claimed = static_cast<double>(calibration.bins.size() + 1);
    calibration.bins.push_back({.state = state, .claimed = claimed, .rmse = claimed, .rows = 70});
  }
  const Figure figure = sigma_figure("log", calibration, {.states = {"v", "k"}, .units = {"m/s", ""}});
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_EQ(figure.panels[0].x_label.text, "claimed σ (m/s)");
  EXPECT_EQ(figure.panels[0].y_label.text, "σ of the errors (m/s)");
  EXPECT_EQ(figure.panels[1].x_label.text, "claimed σ");
  EXPECT_EQ(figure.panels[1].y_label.text, "σ of the errors");
}

// Numbers of a log with measurements that came late, whose RMSE 0.271 was outside its bar.
TEST(SigmaFigure, APointIsOfTheQuantityThatItsBarIsOf) {
  Calibration calibration;
  calibration.bins = {{.state = 0,
                       .claimed = 0.2,
                       .rmse = 0.271,
                       .rows = 70,
                       .factor = {.mean = 1.5625, .lower = 1.2996, .upper = 1.7956}},
                      {.state = 0,
                       .claimed = 0.4,
                       .rmse = 0.5,
                       .rows = 70,
                       .factor = {.mean = kNaN, .lower = kNaN, .upper = kNaN}}};
  const Figure figure = sigma_figure("log", calibration, {.states = {"x"}});
  const Series& measured = figure.panels.at(0).series.at(1);
  EXPECT_NEAR(measured.y[0], 0.25, 1e-12) << "0.2 √1.5625";
  EXPECT_NEAR(measured.lower[0], 0.228, 1e-12);
  EXPECT_NEAR(measured.upper[0], 0.268, 1e-12);
  EXPECT_EQ(measured.y[1], 0.5) << "without a factor";
}

TEST(SigmaFigure, ARangeOfFewRowsIsNoPoint) {
  Calibration calibration;
  for (const std::int64_t rows : {92, 70, 2}) {
    const double claimed = static_cast<double>(calibration.bins.size() + 1);
    calibration.bins.push_back({.claimed = claimed, .rmse = claimed, .rows = rows});
  }
  const Figure figure = sigma_figure("log", calibration, {.states = {"x"}});
  EXPECT_EQ(figure.panels.at(0).series.at(1).x.size(), 2U);
  EXPECT_THAT(figure.caption, testing::HasSubstr("Ranges of fewer than 10 rows are left out."));
}

/// Rows whose errors and claims are all of about these sizes.
Panel stanford_of(const std::vector<StanfordCell>& cells, double k) {
  Calibration calibration;
  calibration.protection[1].k = k;
  calibration.protection[1].rows = 100;
  calibration.stanford = cells;
  const Figure figure = stanford_figure("log", calibration);
  EXPECT_NO_THROW(validate(figure));
  return figure.panels.at(0);
}

double rows_in(const Panel& panel) {
  const Matrix& cells = panel.series.at(0).cells;
  return cells.array().isNaN().select(0.0, cells).sum();
}

// Of one claim, and all errors far within or far beyond it.
TEST(StanfordFigure, TheLineCrossesAllLevelsThatAreShown) {
  for (const double error : {1e-3, 0.9, 30.0}) {
    const Panel panel = stanford_of(
        {{.error = 0.1 * error, .sigma = 0.5, .rows = 7}, {.error = error, .sigma = 0.5, .rows = 5}}, 2.0);
    const Series& line = panel.series.at(1);
    EXPECT_EQ(line.label.text, "error = level");
    const AxisRange x = panel.x_range.value(), y = panel.y_range.value();
    EXPECT_THAT(line.x, ElementsAre(y.low, y.high)) << error;
    EXPECT_EQ(line.x, line.y);
    EXPECT_LE(x.low, y.low) << error;
    EXPECT_GE(x.high, y.high) << error;
    EXPECT_LT(y.low, 0.6);
    EXPECT_GT(y.high, 1.7) << "levels of 1 are in the middle";
    EXPECT_EQ(rows_in(panel), 12.0);
  }
}

TEST(StanfordFigure, RowsAreAtTheirErrorAndLevel) {
  const std::vector<StanfordCell> cells = {{.error = 0.1, .sigma = 0.5, .rows = 3},
                                           {.error = 0.1 * std::pow(10.0, 0.25), .sigma = 0.5, .rows = 4},
                                           {.error = 10.0, .sigma = 5.0, .rows = 5}};
  const Panel panel = stanford_of(cells, 4.0);
  const Series& heat = panel.series.at(0);
  EXPECT_EQ(rows_in(panel), 12.0);
  for (const StanfordCell& cell : cells) {
    const auto nearest = [](const FigureData& centres, double value) {
      return std::ranges::min_element(centres, {}, [&](double c) { return std::abs(std::log(c / value)); }) -
             centres.begin();
    };
    const Index column = nearest(heat.x, cell.error), row = nearest(heat.y, 4.0 * cell.sigma);
    EXPECT_NEAR(heat.x[static_cast<std::size_t>(column)], cell.error, 1e-9 * cell.error);
    EXPECT_NEAR(heat.y[static_cast<std::size_t>(row)], 4.0 * cell.sigma, 1e-9 * cell.sigma);
    EXPECT_EQ(heat.cells(row, column), static_cast<double>(cell.rows));
  }
}

TEST(DistanceFigure, AnAxisIsLogarithmicWhereValuesSpanDecades) {
  const auto panels = [](double last) {
    Calibration calibration;
    calibration.distance = {length(0.0, kNaN), length(10.0, kNaN)};
    for (DistanceBin& bin : calibration.distance) bin.error_m = bin.sigma_m = 0.5;
    calibration.distance[1].nees = {.mean = last, .lower = -1.0, .upper = 2.0 * last, .count = 6};
    calibration.distance[1].error_m = std::sqrt(last);
    const Figure figure = distance_figure("log", calibration);
    EXPECT_NO_THROW(validate(figure));
    return figure.panels;
  };
  EXPECT_FALSE(panels(3.0).at(0).log_y);
  EXPECT_FALSE(panels(3.0).at(1).log_y);
  const std::vector<Panel> diverged = panels(13273.0);
  EXPECT_TRUE(diverged.at(0).log_y);
  EXPECT_TRUE(diverged.at(1).log_y);
  EXPECT_LT(diverged[0].y_range->low, 1.0);
  EXPECT_GT(diverged[0].y_range->high, 2.0 * 13273.0);
  EXPECT_EQ(diverged[0].series.at(1).lower.at(1), diverged[0].y_range->low) << "of a bar that goes below 0";
}

TEST(CalibrationJson, FactorsByPartAreNullWhereTheStateIsOnePart) {
  Calibration calibration;
  const std::vector<std::string> states = {"x"};
  const auto held_out = [&] { return calibration_json(calibration, {}, states)["held_out_nees_over_dof"]; };
  EXPECT_TRUE(held_out()["with_part_factors"].is_null());
  EXPECT_TRUE(held_out()["with_factor"].is_object());
  calibration.parts.resize(2);
  EXPECT_TRUE(held_out()["with_part_factors"].is_object());
}

}  // namespace
}  // namespace credence::internal
