#include "reports/document/sweep/sweep_figures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Configuration n (from 1) has mean NEES n, expected 2, to be accepted from 1.6 to 2.5; of NIS the half.
SweepAnalysis numbered_sweep(const std::string& axes, const std::string& model = "planar") {
  SweepPlan plan =
      plan_sweep(read_scenario_text("[world]\nmodel = \"" + model + "\"\n[sweep]\n" + axes, "s.toml"));
  SweepAnalysis sweep;
  for (std::size_t n = 0; n < plan.points.size(); ++n) {
    StudyAnalysis study;
    study.scenario = plan.points[n].scenario;
    study.nees.mean = static_cast<double>(n + 1);
    study.nees.expected = 2.0;
    study.nees.bounds = {1.6, 2.5};
    study.nees.verdict = n == 1 ? Verdict::consistent : Verdict::optimistic;
    study.nis = study.nees;
    study.nis.mean *= 0.5;
    sweep.studies.push_back(study);
    sweep.points.push_back(n);
  }
  sweep.plan = std::move(plan);
  return sweep;
}

Panel nees_of_figure(const std::string& axes, const std::string& model = "planar") {
  const std::vector<Figure> figures = sweep_figures(numbered_sweep(axes, model));
  EXPECT_EQ(figures.size(), 1U) << axes;
  EXPECT_NO_THROW(validate(figures.at(0)));
  EXPECT_EQ(figures[0].panels.size(), 2U);
  return figures[0].panels.at(0);
}

constexpr const char* kLandmarks = "world.landmarks = [3, 4, 5]\n";

TEST(SweepFigures, ACurveHasTheRatioAndTheFactorsThatAgreeWithIt) {
  const Panel panel = nees_of_figure(kLandmarks);
  EXPECT_EQ(panel.x_label.text, "world.landmarks");
  ASSERT_EQ(panel.series.size(), 4U);
  const Series &band = panel.series[0], &measured = panel.series[3];
  EXPECT_EQ(measured.label.text, "measured");
  EXPECT_THAT(measured.x, ElementsAre(3.0, 4.0, 5.0));
  EXPECT_THAT(measured.y, ElementsAre(0.5, 1.0, 1.5));
  // A factor f on P makes mean / f of the mean: it is accepted from 1.6 to 2.5.
  EXPECT_THAT(measured.lower, ElementsAre(1.0 / 2.5, 2.0 / 2.5, 3.0 / 2.5));
  EXPECT_THAT(measured.upper, ElementsAre(1.0 / 1.6, 2.0 / 1.6, 3.0 / 1.6));
  EXPECT_THAT(band.lower, ElementsAre(0.8, 0.8, 0.8));
  EXPECT_THAT(band.upper, ElementsAre(1.25, 1.25, 1.25));
  const std::vector<Figure> figures = sweep_figures(numbered_sweep(kLandmarks));
  EXPECT_THAT(figures[0].panels[1].series[3].y, ElementsAre(0.25, 0.5, 0.75));
}

TEST(SweepFigures, AnAxisIsLogarithmicWhereItsValuesAre) {
  EXPECT_FALSE(nees_of_figure(kLandmarks).log_x);
  EXPECT_TRUE(nees_of_figure("noise.range_std = [0.01, 0.1, 1.0]\n").log_x);
  EXPECT_FALSE(nees_of_figure("noise.range_std = [0.1, 0.2]\n").log_x);
}

TEST(SweepFigures, BarsStandBesideEachOtherAndOffTheFrame) {
  const Panel panel = nees_of_figure(std::string(kLandmarks) + "filter.inflation = [\"none\", \"map\"]\n");
  EXPECT_LT(panel.x_range.value().low, 3.0);
  EXPECT_GT(panel.x_range.value().high, 5.0);
  std::vector<double> aside;
  for (const Series& series : panel.series) {
    if (series.kind == SeriesKind::error_bars) aside.push_back(series.aside);
  }
  EXPECT_THAT(aside, ElementsAre(-2.0, 2.0));
  EXPECT_EQ(nees_of_figure(kLandmarks).series.at(3).aside, 0.0);
}

std::vector<std::string> curve_labels(const Panel& panel) {
  std::vector<std::string> labels;
  for (const Series& series : panel.series) {
    if (series.kind == SeriesKind::error_bars) labels.push_back(series.label.text);
  }
  return labels;
}

// Inside the band of another curve a point may be a verdict.
TEST(SweepFigures, ABandIsDrawnWhereItIsThatOfAllCurves) {
  const std::string two = std::string(kLandmarks) + "filter.inflation = [\"none\", \"map\"]\n";
  const auto has_band = [](const Panel& panel) {
    return std::ranges::find(panel.series, SeriesKind::band, &Series::kind) != panel.series.end();
  };
  EXPECT_TRUE(has_band(nees_of_figure(two)));
  SweepAnalysis sweep = numbered_sweep(two);
  sweep.studies.at(3).nees.bounds = {1.0, 3.0};
  const std::vector<Figure> figures = sweep_figures(sweep);
  EXPECT_NO_THROW(validate(figures.at(0)));
  EXPECT_FALSE(has_band(figures[0].panels.at(0)));
  EXPECT_TRUE(has_band(figures[0].panels.at(1))) << "those of NIS are the same";
  SweepAnalysis one = numbered_sweep(kLandmarks);
  one.studies.at(1).nees.bounds = {1.0, 3.0};
  EXPECT_TRUE(has_band(sweep_figures(one).at(0).panels.at(0))) << "of one curve, wider here";
}

TEST(SweepFigures, EachSettingOfTheOtherAxesHasACurve) {
  const Panel panel = nees_of_figure(std::string(kLandmarks) + "filter.inflation = [\"none\", \"map\"]\n");
  EXPECT_THAT(curve_labels(panel), ElementsAre("inflation = none", "inflation = map"));
}

TEST(SweepFigures, KeysThatEndAlikeAreNamedInFull) {
  const Panel panel = nees_of_figure(
      "study.steps = [10, 20, 30]\nnoise.position_std = [1.0, 2.0]\ninitial.position_std = [3.0]\n",
      "tracking");
  EXPECT_THAT(curve_labels(panel), ElementsAre("noise.position_std = 1.0, initial.position_std = 3.0",
                                               "noise.position_std = 2.0, initial.position_std = 3.0"));
}

TEST(SweepFigures, TwoAxesOfThreeValuesAreAMapWithEachRatioInItsCell) {
  const SweepAnalysis sweep = numbered_sweep(std::string(kLandmarks) + "noise.range_std = [0.1, 0.2, 0.3]\n");
  const Panel panel = nees_of_figure(std::string(kLandmarks) + "noise.range_std = [0.1, 0.2, 0.3]\n");
  const Series& heat = panel.series.at(0);
  ASSERT_EQ(heat.kind, SeriesKind::heat_map);
  for (std::size_t n = 0; n < 9; ++n) {
    const Scenario& scenario = sweep.studies[n].scenario;
    const auto place = [](const FigureData& centres, double value) {
      return std::ranges::find_if(centres, [&](double c) { return std::abs(c - value) < 1e-9; }) -
             centres.begin();
    };
    const Index column = place(heat.x, static_cast<double>(scenario.world.landmarks));
    const Index row = place(heat.y, scenario.noise.range_std);
    ASSERT_TRUE(column < 3 && row < 3);
    EXPECT_EQ(heat.cells(row, column), sweep.studies[n].nees.mean / 2.0);
  }
  // The middle of a diverging scale is 1 on a logarithmic one, and the largest ratio is at its end.
  ASSERT_TRUE(panel.colour_range.has_value());
  EXPECT_NEAR(panel.colour_range->low * panel.colour_range->high, 1.0, 1e-12);
  EXPECT_NEAR(panel.colour_range->high, 4.5, 1e-12);
  EXPECT_EQ(panel.series.at(1).x.size(), 1U) << "a dot for the one that is consistent";
}

TEST(SweepFigures, WithoutNumbersOrResultsThereIsNone) {
  EXPECT_THAT(sweep_figures(numbered_sweep("filter.inflation = [\"none\", \"map\"]\n")), IsEmpty());
  SweepAnalysis none = numbered_sweep(kLandmarks);
  none.studies.clear();
  EXPECT_THAT(sweep_figures(none), IsEmpty());
}

TEST(SweepFigures, WhatHasNoResultBreaksALineAndIsNoCell) {
  SweepAnalysis sweep = numbered_sweep(kLandmarks);
  sweep.studies[1].nees = {};
  sweep.studies[1].nees.mean = sweep.studies[1].nees.expected = kNaN;
  const std::vector<Figure> figures = sweep_figures(sweep);
  EXPECT_NO_THROW(validate(figures.at(0)));
  EXPECT_TRUE(std::isnan(figures[0].panels[0].series[2].y[1]));
  EXPECT_THAT(figures[0].panels[0].series[0].x, ElementsAre(3.0, 5.0));
}

// Whatever the order of the list, its line does not go to and fro.
TEST(SweepFigures, ALineGoesFromTheSmallestValueToTheLargest) {
  SweepAnalysis backwards = numbered_sweep(kLandmarks);
  std::ranges::reverse(backwards.studies);
  std::ranges::reverse(backwards.points);
  const std::vector<Figure> figures = sweep_figures(backwards);
  const std::vector<Figure> ordered = sweep_figures(numbered_sweep(kLandmarks));
  ASSERT_EQ(figures.size(), 1U);
  for (std::size_t panel = 0; panel < 2; ++panel) {
    const std::vector<Series>& series = figures[0].panels[panel].series;
    for (std::size_t i = 2; i < series.size(); ++i) {
      EXPECT_TRUE(std::ranges::is_sorted(series[i].x));
      EXPECT_EQ(series[i].y, ordered[0].panels[panel].series[i].y);
    }
  }
}

}  // namespace
}  // namespace credence::internal
