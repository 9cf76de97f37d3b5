#include "reports/figures/estimator_figures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "core/nan.h"
#include "reports/figures/figure_layout.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

EstimatorRow estimator(const std::string& name, double nees) {
  EstimatorRow row{.name = name, .profile = {.seconds_per_step = 2e-6 * nees}, .runs = 20, .failures = {}};
  row.nees.fill({.mean = nees, .lower = 0.9 * nees, .upper = 1.2 * nees, .count = 20});
  row.bands.fill({0.1 * nees, 0.5 * nees, nees, 2.0 * nees, 4.0 * nees});
  row.position_rmse_m = {.mean = 0.1 * nees, .count = 20};
  row.pose_nees = {nees, 2.0 * nees};
  return row;
}

EstimatorStudy three_estimators() {
  EstimatorStudy study;
  study.rows = {estimator("ideal", 1.0), estimator("ekf", 3.0), estimator("failed", 9.0)};
  study.rows[2].runs = 1;  // one run is no sample
  study.window_ends = {10.0, 20.0};
  study.scenario.study.confidence = 0.95;
  return study;
}

const Series* estimator_series(const Panel& panel, const std::string& label) {
  const auto found =
      std::ranges::find_if(panel.series, [&](const Series& s) { return s.label.text == label; });
  return found == panel.series.end() ? nullptr : &*found;
}

TEST(EstimatorFigures, EachEstimatorStandsAtItsErrorItsCostAndItsTime) {
  const std::vector<Figure> figures = estimator_figures(three_estimators());
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_NO_THROW(validate(figures[0]));
  const std::vector<Panel>& panels = figures[0].panels;
  ASSERT_EQ(panels.size(), 4U);
  const Series* accuracy = estimator_series(panels[0], "2: ekf");
  ASSERT_NE(accuracy, nullptr);
  EXPECT_THAT(accuracy->x, ElementsAre(testing::DoubleEq(0.3)));
  EXPECT_THAT(accuracy->y, ElementsAre(3.0));
  EXPECT_THAT(accuracy->lower, ElementsAre(testing::DoubleEq(2.7)));
  EXPECT_THAT(accuracy->upper, ElementsAre(testing::DoubleEq(3.6)));
  EXPECT_THAT(estimator_series(panels[1], "2: ekf")->x, ElementsAre(testing::DoubleEq(6.0))) << "µs";
  EXPECT_THAT(estimator_series(panels[2], "2: ekf")->x, ElementsAre(10.0, 20.0));
  EXPECT_THAT(estimator_series(panels[2], "2: ekf")->y, ElementsAre(3.0, 6.0));
  const Series* runs = estimator_series(panels[3], "2: ekf");
  ASSERT_NE(runs, nullptr);
  EXPECT_THAT(runs->x, ElementsAre(2.0));
  EXPECT_THAT(runs->y, ElementsAre(3.0)) << "the median";
  EXPECT_THAT(runs->lower, ElementsAre(testing::DoubleEq(0.3)));
  EXPECT_THAT(runs->upper, ElementsAre(12.0));
}

TEST(EstimatorFigures, WhatHasNoRunsIsLeftOutAndTheYardstickHasAColourOfItsOwn) {
  EstimatorStudy study = three_estimators();
  const Figure figure = estimator_figures(study).at(0);
  for (const Panel& panel : figure.panels) EXPECT_EQ(estimator_series(panel, "3: failed"), nullptr);
  EXPECT_EQ(estimator_series(figure.panels[0], "1: ideal")->role, ColourRole::truth);
  EXPECT_EQ(estimator_series(figure.panels[0], "2: ekf")->role, numbered_role(0));
  for (EstimatorRow& row : study.rows) row.runs = 1;
  EXPECT_TRUE(estimator_figures(study).empty());
}

TEST(EstimatorFigures, NoTwoOfManyLookAlike) {
  EstimatorStudy study = three_estimators();
  study.rows.clear();
  for (int i = 0; i < 16; ++i) study.rows.push_back(estimator(i == 5 ? "ideal" : fmt::format("e{}", i), 2.0));
  const Figure figure = estimator_figures(study).at(0);
  std::set<std::tuple<ColourRole, MarkerShape>> points;
  std::set<std::tuple<ColourRole, StrokeStyle>> lines;
  for (int i = 0; i < 16; ++i) {
    const std::string label = fmt::format("{}: {}", i + 1, i == 5 ? "ideal" : fmt::format("e{}", i));
    const Series *point = estimator_series(figure.panels[0], label),
                 *line = estimator_series(figure.panels[2], label);
    ASSERT_TRUE(point != nullptr && line != nullptr) << label;
    EXPECT_TRUE(points.emplace(point->role, point->marker).second) << label;
    EXPECT_TRUE(lines.emplace(line->role, line->stroke).second) << label;
  }
}

TEST(EstimatorFigures, OneLegendIsThatOfAllPanels) {
  EstimatorStudy study = three_estimators();
  for (int i = 0; i < 9; ++i) study.rows.push_back(estimator(fmt::format("e{}", i), 2.0));
  const FigureLayout layout = lay_out(estimator_figures(study).at(0), 900.0);
  EXPECT_EQ(layout.panels[0].legend.size(), 1U + 11U)
      << "the line of consistency, and all but the one that failed";
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_TRUE(layout.panels[i].legend.empty()) << i;
}

TEST(EstimatorFigures, AnIntervalThatIsNotKnownIsNoBar) {
  EstimatorStudy study = three_estimators();
  study.rows[1].nees.fill({.mean = 3.0, .lower = kNaN, .upper = kNaN, .count = 2});
  const Figure figure = estimator_figures(study).at(0);
  EXPECT_NO_THROW(validate(figure));
  EXPECT_THAT(estimator_series(figure.panels[0], "2: ekf")->upper, ElementsAre(3.0));
}

TEST(EstimatorFigures, WithoutAVehicleNothingIsAPose) {
  EstimatorStudy study = three_estimators();
  EXPECT_EQ(estimator_figures(study)[0].panels[0].y_label.text, "pose NEES over dof");
  study.has_vehicle = false;
  const Figure figure = estimator_figures(study).at(0);
  EXPECT_EQ(figure.panels[0].y_label.text, "NEES over dof");
  EXPECT_EQ(figure.panels[0].x_label.text, "RMSE of the state");
  EXPECT_EQ(figure.caption.find("pose"), std::string::npos);
}

}  // namespace
}  // namespace credence::internal
