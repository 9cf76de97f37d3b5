#include "reports/document/estimators/estimator_map_report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "montecarlo/scenario/scenario_io.h"
#include "reports/render/text_page.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Two estimators at every point of a sweep; "b" is dearer. NEES of the pose: 1 and 1.
EstimatorMap map_of(const std::string& sweep) {
  EstimatorMap map;
  map.plan = plan_sweep(read_scenario_text("[world]\nmodel = \"planar\"\n[sweep]\n" + sweep, "s.toml"));
  map.names = {"a", "b"};
  map.seconds_per_step = {1e-6, 5e-6};
  for (const SweepPoint& point : map.plan.points) {
    EstimatorStudy study;
    study.scenario = point.scenario;
    study.runs = 20;
    for (const std::string& name : map.names) {
      EstimatorRow row{.name = name, .profile = {}, .runs = 20, .failures = {}};
      row.nees.fill({.mean = 1.0, .lower = 0.9, .upper = 1.1});
      study.rows.push_back(row);
    }
    map.studies.push_back(study);
  }
  return map;
}

MeanInterval& nees_of(EstimatorMap& map, std::size_t point, std::size_t estimator) {
  return map.studies[point].rows[estimator].nees[static_cast<std::size_t>(EstimatorBlock::pose)];
}

constexpr const char* kTwoAxes = "world.landmarks = [3, 6, 9]\nnoise.range_std = [0.1, 0.2]\n";

void see_optimistic(EstimatorMap& map, std::size_t point, std::size_t estimator, double mean) {
  nees_of(map, point, estimator) = {.mean = mean, .lower = 0.9 * mean, .upper = 1.1 * mean};
  map.studies[point].rows[estimator].beyond_tolerance = {.optimistic = 1e-6, .pessimistic = 1.0};
}

void see_pessimistic(EstimatorMap& map, std::size_t point, std::size_t estimator, double mean) {
  nees_of(map, point, estimator) = {.mean = mean, .lower = 0.9 * mean, .upper = 1.1 * mean};
  map.studies[point].rows[estimator].beyond_tolerance = {.optimistic = 1.0, .pessimistic = 1e-6};
}

/// At the first point both stay consistent, at the second only "b", at the third a run of "b" failed.
EstimatorMap some_of_each() {
  EstimatorMap map = map_of(kTwoAxes);
  see_optimistic(map, 1, 0, 2.0);
  see_optimistic(map, 2, 0, 4.0);
  map.studies[2].rows[1].runs = 19;
  map.studies[2].rows[1].failures = {{.run = 3, .step = 2, .outcome = Outcome::diverged}};
  return map;
}

const ReportTable& shown_table(const Document& document) {
  return std::get<ReportTable>(document.brief.front());
}

TEST(EstimatorMapReport, TheAnswerCountsEveryPointOnce) {
  const Document document = estimator_map_document(some_of_each());
  EXPECT_EQ(document.answer.text,
            "The cheapest estimator whose pose stays consistent, of 6 points: a at 4, b at 1, none at 1");
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  EXPECT_EQ(estimator_map_document(map_of(kTwoAxes)).answer.tone, CellTone::good);
}

TEST(EstimatorMapReport, HowFarTheMeansMayBeIsSaid) {
  EstimatorMap map = map_of(kTwoAxes);
  nees_of(map, 2, 0) = {.mean = 1.05, .lower = 0.625, .upper = 1.5};
  EXPECT_THAT(shown_table(estimator_map_document(map)).notes,
              Contains(HasSubstr("it may be anywhere from 0.625 to 1.50, by their intervals")));
  nees_of(map, 2, 1) = {.mean = 1.0, .lower = 0.1, .upper = 9.0};
  EXPECT_THAT(shown_table(estimator_map_document(map)).notes, Contains(HasSubstr("0.625 to 1.50")))
      << "not named";
}

TEST(EstimatorMapReport, WhatIsGreyIsSaidBelowAndNotAlongTheColourBar) {
  const Document document = estimator_map_document(map_of(kTwoAxes));
  EXPECT_EQ(figure_of(document, "cheapest").panels.at(0).colour_label.text, "its time per step (µs)");
  EXPECT_THAT(figure_of(document, "cheapest").caption, HasSubstr("grey: none does"));
  EXPECT_EQ(figure_of(document, "nees").panels.at(0).colour_label.text, "Pose NEES over dof");
  EXPECT_THAT(figure_of(document, "nees").caption, HasSubstr("grey: no run ended well"));
}

TEST(EstimatorMapReport, TableAndDataSayTheSameOfEveryPoint) {
  const EstimatorMap map = some_of_each();
  const Document document = estimator_map_document(map);
  const ReportTable& table = shown_table(document);
  const auto j = nlohmann::json::parse(document.json());
  ASSERT_EQ(table.rows.size(), 6U);
  ASSERT_EQ(j["points"].size(), 6U);
  for (std::size_t p = 0; p < 6; ++p) {
    const auto& best = j["points"][p]["cheapest"];
    EXPECT_EQ(table.rows[p][2].text, best.is_null() ? "none" : best.get<std::string>());
    EXPECT_EQ(j["points"][p]["values"]["world.landmarks"].dump(), table.rows[p][0].text);
  }
  EXPECT_EQ(table.rows[1][2].text, "b");
  EXPECT_EQ(table.rows[1][3].text, "2.00");
  EXPECT_EQ(table.rows[1][3].tone, CellTone::alarm);
  EXPECT_EQ(table.rows[2][2].text, "none");
  EXPECT_EQ(table.rows[2][4].text, "1 failed");
  EXPECT_EQ(j["estimators"][1]["seconds_per_step"], 5e-6);
  EXPECT_EQ(j["points"][2]["study"]["rows"][1]["estimator"], "b");
}

// An estimator that claims errors larger than it has is told apart from one that may be trusted.
TEST(EstimatorMapReport, PessimisticIsNotConsistent) {
  EstimatorMap map = some_of_each();
  for (const std::size_t point : {3U, 4U}) see_pessimistic(map, point, 0, 0.5);
  const Document document = estimator_map_document(map);
  EXPECT_EQ(document.answer.text,
            "The cheapest estimator whose pose stays consistent, of 6 points: a at 2, b at 3, none at 1");
  const ReportTable& table = shown_table(document);
  EXPECT_EQ(table.rows[3][2].text, "b");
  EXPECT_EQ(table.rows[3][3].text, "0.500");
  EXPECT_EQ(table.rows[3][3].tone, CellTone::caution);
  EXPECT_THAT(table.notes, Contains("Optimistic, without a failed run: a at 2."));
  EXPECT_THAT(table.notes, Contains("Pessimistic: a at 2."));
  const auto of_point = nlohmann::json::parse(document.json())["points"][3]["estimators"];
  EXPECT_EQ(of_point[0]["verdict"], "pessimistic");
  EXPECT_EQ(of_point[0]["pessimistic_p_value"], 1e-6);
  EXPECT_EQ(of_point[1]["verdict"], "consistent");
}

TEST(EstimatorMapReport, CellsLieAtTheValuesOfTheirPoint) {
  const EstimatorMap map = some_of_each();
  const Figure figure = figure_of(estimator_map_document(map), "cheapest");
  const Series &heat = figure.panels.at(0).series.at(0), &words = figure.panels.at(0).series.at(1);
  ASSERT_EQ(heat.cells.rows(), 2);
  ASSERT_EQ(heat.cells.cols(), 3);
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const Scenario& scenario = map.plan.points[p].scenario;
    const Index column = scenario.world.landmarks / 3 - 1, row = scenario.noise.range_std > 0.15 ? 1 : 0;
    const double microseconds = heat.cells(row, column);
    if (p == 2) EXPECT_TRUE(std::isnan(microseconds));
    if (p != 2) EXPECT_DOUBLE_EQ(microseconds, p == 1 ? 5.0 : 1.0);
    EXPECT_EQ(words.texts[p].text, p == 2 ? "none" : p == 1 ? "b" : "a");
    EXPECT_NEAR(words.x[p], static_cast<double>(column) + 1.0, 0.5) << "within its cell";
    EXPECT_NEAR(words.y[p], static_cast<double>(row) + 1.0, 0.5);
  }
  EXPECT_NO_THROW(validate(figure));
}

TEST(EstimatorMapReport, OfSeveralPointsTheWorstNeesIsDrawn) {
  EstimatorMap map = some_of_each();
  for (std::size_t p = 4; p < 6; ++p) {
    map.studies[p].rows[1].runs = 0;
    nees_of(map, p, 1).mean = 50.0;  // of no run
  }
  const Figure figure = figure_of(estimator_map_document(map), "nees");
  const Matrix& cells = figure.panels.at(0).series.at(0).cells;  // estimators over landmarks
  ASSERT_EQ(cells.rows(), 2);
  ASSERT_EQ(cells.cols(), 3);
  EXPECT_EQ(cells(0, 0), 2.0);
  EXPECT_EQ(cells(0, 1), 4.0);
  EXPECT_EQ(cells(0, 2), 1.0);
  EXPECT_EQ(cells(1, 0), 1.0);
  EXPECT_TRUE(std::isnan(cells(1, 2)));
  EXPECT_NO_THROW(validate(figure));
}

TEST(EstimatorMapReport, FiguresAreOfGrids) {
  const auto drawn = [](const std::string& sweep, const char* name) {
    try {
      figure_of(estimator_map_document(map_of(sweep)), name);
    } catch (const std::out_of_range&) {
      return false;
    }
    return true;
  };
  EXPECT_TRUE(drawn("world.landmarks = [3, 6]\n", "nees"));
  EXPECT_FALSE(drawn("world.landmarks = [3, 6]\n", "cheapest"));
  EXPECT_FALSE(drawn("mode = \"zip\"\nworld.landmarks = [3, 6]\nnoise.range_std = [0.1, 0.2]\n", "nees"));
}

// Any states have neither headings nor metres, nor a pose.
TEST(EstimatorMapReport, OfALinearWorldSpeaksOfTheState) {
  const SweepPlan plan = plan_sweep(read_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[0.9]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = "
      "[[1]]\n[study]\nruns = 4\nsteps = 5\n[sweep]\nnoise.detection_probability = [1.0, 0.8]\n",
      "s.toml"));
  const EstimatorMap map = map_estimators(plan, {.threads = 1});
  const Document document = estimator_map_document(map);
  EXPECT_THAT(text_page(document), Not(HasSubstr("ose NEES")));
  EXPECT_THAT(text_page(document), HasSubstr("NEES over dof"));
  const Figure figure = figure_of(document, "nees");
  EXPECT_THAT(figure.caption, Not(HasSubstr("pose")));
  EXPECT_THAT(figure.panels[0].title.text + figure.panels[0].colour_label.text, Not(HasSubstr("ose NEES")));
  EXPECT_THAT(shown_table(document).notes.back(), HasSubstr("smoother is left out"));
  EXPECT_THAT(shown_table(document).notes.front(), HasSubstr("The world has no ideal filter."));
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["left_out"].size(), map.left_out.size());
}

// Of a filter that is not compared nothing is said, but where the world has none.
TEST(EstimatorMapReport, SaysOfTheIdealFilterWhatIsSoInThisWorld) {
  const auto said = [](const std::string& world, std::vector<std::string> names) {
    EstimatorMap map = map_of("study.steps = [3, 6]\n");
    for (EstimatorStudy& study : map.studies)
      study.scenario = load_scenario_text("[world]\nmodel = \"" + world + "\"\n", "s.toml", {});
    map.names = std::move(names);
    return shown_table(estimator_map_document(map)).notes.front();
  };
  EXPECT_THAT(said("planar_slam", {"ekf", "ideal"}), HasSubstr("ideal is not asked"));
  EXPECT_THAT(said("planar_slam", {"ekf", "fej"}), Not(HasSubstr("ideal")));
  EXPECT_THAT(said("spatial_slam", {"ekf", "ideal"}), HasSubstr("ideal is not asked"));
  const std::string of_none = said("planar", {"a", "b"});
  EXPECT_THAT(of_none, HasSubstr("The world has no ideal filter."));
  EXPECT_THAT(of_none, Not(HasSubstr("not asked")));
}

}  // namespace
}  // namespace credence::internal
