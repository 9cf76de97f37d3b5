#include "reports/figures/replay_figures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace credence::internal {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;

constexpr double kPi = std::numbers::pi;

/// Two times, two surveyed landmarks of which the second is mapped, and a third of the map that is not
/// surveyed.
ReplayResult short_replay() {
  ReplayResult r;
  r.survey_m = {Point(10.0, 20.0), Point(30.0, 40.0)};
  const auto landmark = [](int number, double x, double y, double variance) {
    ReplayLandmark l;
    l.landmark = number;
    l.position = Point(x, y);
    l.covariance = variance * Eigen::Matrix2d::Identity();
    l.gain = {.range = 0.5, .bearing = 0.25};
    return l;
  };
  for (int k = 0; k < 2; ++k) {
    ReplayStep step;
    step.time_s = 1.0 + k;
    step.pose = Pose(1.0 * k, 2.0 * k, 0.0);
    step.covariance = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
    step.gain = {.range = 0.75, .bearing = 0.125};
    if (k > 0) step.landmarks = {landmark(1, 30.5, 39.75, 0.25), landmark(-1, 5.0, 5.0, 1.0)};
    r.steps.push_back(step);
    ReplayReference ref;
    ref.time_s = 1.0 + k;
    ref.estimate = Pose(1.5, 2.5, kPi - 0.1);
    ref.truth = Pose(1.0, 3.0, -kPi + 0.1);
    ref.covariance = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
    ref.dof = 3;
    r.references.push_back(ref);
  }
  r.map = r.steps.back().landmarks;
  return r;
}

const Series& series_named(const Panel& panel, const std::string& label) {
  const auto found =
      std::ranges::find_if(panel.series, [&](const Series& s) { return s.label.text == label; });
  if (found == panel.series.end()) throw std::out_of_range(label);
  return *found;
}

const Panel& panel_named(const Figure& figure, const std::string& title) {
  const auto found =
      std::ranges::find_if(figure.panels, [&](const Panel& p) { return p.title.text == title; });
  if (found == figure.panels.end()) throw std::out_of_range(title);
  return *found;
}

// "‖" is in none of the fonts that PDFs are drawn with.
TEST(ReplayFigures, NormsAreWrittenInLettersOfEveryFont) {
  const Figure figure = replay_run_figure("r", "", short_replay());
  EXPECT_EQ(panel_named(figure, "Gain of the range").y_label.text, "|K| (m/m)");
  EXPECT_EQ(panel_named(figure, "Gain of the bearing").y_label.text, "|K| (m/rad)");
}

TEST(ReplayFigures, ErrorsAreEstimateMinusTruthWithTwoSigma) {
  const Figure figure = replay_run_figure("r", "c", short_replay());
  EXPECT_NO_THROW(validate(figure));
  const Panel& x = panel_named(figure, "Vehicle error in x");
  EXPECT_THAT(series_named(x, "error").y, ElementsAre(0.5, 0.5));
  EXPECT_THAT(series_named(x, "±2σ").y, ElementsAre(DoubleEq(-0.4), DoubleEq(-0.4)));
  EXPECT_THAT(x.series.at(1).y, ElementsAre(DoubleEq(0.4), DoubleEq(0.4)));
  EXPECT_THAT(series_named(panel_named(figure, "Vehicle error in y"), "error").y, ElementsAre(-0.5, -0.5));
}

TEST(ReplayFigures, AHeadingIsInDegreesAndWrapped) {
  const Panel heading = panel_named(replay_run_figure("r", "c", short_replay()), "Vehicle error in heading");
  // From −π + 0.1 to π − 0.1 it is 0.2 rad to the right.
  EXPECT_NEAR(series_named(heading, "error").y[0], -0.2 * 180.0 / kPi, 1e-9);
  EXPECT_NEAR(heading.series.at(1).y[0], 0.2 * 180.0 / kPi, 1e-9);
  ReplayResult without = short_replay();
  for (ReplayReference& ref : without.references) ref.dof = 2;
  const Figure figure = replay_run_figure("r", "c", without);
  EXPECT_THROW(panel_named(figure, "Vehicle error in heading"), std::out_of_range) << "GPS gives none";
  EXPECT_NO_THROW(validate(figure));
  EXPECT_EQ(replay_map_panel("m", without).series.at(0).label.text, "GPS");
  EXPECT_EQ(replay_map_panel("m", short_replay()).series.at(0).label.text, "motion capture");
}

TEST(ReplayFigures, LandmarksAreNumberedFromOneAndJudgedByTheirOwnSurvey) {
  const Figure figure = replay_run_figure("r", "c", short_replay());
  const Panel& x = panel_named(figure, "Landmark errors in x");
  EXPECT_THAT(series_named(x, "2").x, ElementsAre(2.0));
  EXPECT_THAT(series_named(x, "2").y, ElementsAre(0.5));
  EXPECT_THAT(series_named(panel_named(figure, "Landmark errors in y"), "2").y, ElementsAre(-0.25));
  EXPECT_EQ(x.series.size(), 4U + 1U) << "what the survey does not know has no error";
}

TEST(ReplayFigures, TheBoundsOfManyLandmarksAreABandAndTheirMedian) {
  ReplayResult r = short_replay();
  const auto landmark = [](int number, double x, double sigma) {
    ReplayLandmark l;
    l.landmark = number;
    l.position = Point(x, 0.0);
    l.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
    return l;
  };
  r.survey_m.assign(4, Point(0.0, 0.0));
  r.steps[0].landmarks = {landmark(2, 0.0, 0.5), landmark(0, 0.5, 0.25), landmark(-1, 0.0, 9.0)};
  r.steps[1].landmarks = {landmark(2, 0.75, 0.25), landmark(0, 1.0, 1.0), landmark(3, 0.0, 0.5)};
  const Panel x = panel_named(replay_run_figure("r", "c", r), "Landmark errors in x");
  const Series& band = series_named(x, "±2σ, smallest to largest");
  EXPECT_EQ(band.kind, SeriesKind::band);
  EXPECT_THAT(band.x, ElementsAre(1.0, 2.0));
  EXPECT_THAT(band.lower, ElementsAre(0.5, 0.5));
  EXPECT_THAT(band.upper, ElementsAre(1.0, 2.0));
  EXPECT_THAT(x.series.at(1).lower, ElementsAre(-1.0, -2.0));
  EXPECT_THAT(x.series.at(1).upper, ElementsAre(-0.5, -0.5));
  EXPECT_THAT(series_named(x, "±2σ, median").y, ElementsAre(-0.75, -1.0));
  EXPECT_THAT(x.series.at(3).y, ElementsAre(0.75, 1.0));
  // The errors of three landmarks, of which one is beyond its own 2σ at the second step.
  ASSERT_EQ(x.series.size(), 4U + 3U + 1U);
  EXPECT_EQ(x.series.at(5).label.text, "3");
  EXPECT_THAT(x.series.at(5).y, ElementsAre(0.0, 0.75));
  EXPECT_THAT(x.series.at(6).y, ElementsAre(testing::IsNan(), 0.75));
  EXPECT_GT(x.series.at(6).weight, x.series.at(5).weight);
  EXPECT_EQ(x.series.at(6).role, x.series.at(5).role);
}

TEST(ReplayFigures, GainsAndTracesAreThoseOfTheSteps) {
  const Figure figure = replay_run_figure("r", "c", short_replay());
  const Panel &range = panel_named(figure, "Gain of the range"),
              &bearing = panel_named(figure, "Gain of the bearing");
  EXPECT_THAT(series_named(range, "vehicle position").y, ElementsAre(0.75, 0.75));
  EXPECT_THAT(series_named(bearing, "vehicle position").y, ElementsAre(0.125, 0.125));
  EXPECT_THAT(range.series.at(0).y, ElementsAre(0.5));
  const Panel& traces = panel_named(figure, "Traces of the covariance");
  EXPECT_NEAR(series_named(traces, "vehicle position").y[0], 0.04 + 0.09, 1e-15) << "position alone";
  EXPECT_TRUE(std::isnan(series_named(traces, "all landmarks").y[0])) << "none yet, and the axis has no zero";
  EXPECT_NEAR(series_named(traces, "all landmarks").y[1], 2 * 0.25 + 2 * 1.0, 1e-15);
}

TEST(ReplayFigures, EveryInnovationIsDrawnOnceByWhatBecameOfIt) {
  ReplayResult r = short_replay();
  const auto observed = [&](ObservationOutcome outcome, double nis) {
    ReplayObservation o;
    o.time_s = static_cast<double>(r.records.size());
    o.outcome = outcome;
    o.nis = nis;
    r.records.push_back(o);
  };
  observed(ObservationOutcome::updated, 1.5);
  observed(ObservationOutcome::rejected, 30.0);
  observed(ObservationOutcome::initialised, 0.0);
  observed(ObservationOutcome::updated, 1e-9);
  observed(ObservationOutcome::unassociated, 0.0);
  const Figure figure = replay_run_figure("r", "c", r);
  EXPECT_NO_THROW(validate(figure));
  const Panel& nis = panel_named(figure, "NIS of single observations");
  EXPECT_THAT(series_named(nis, "used").x, ElementsAre(0.0));
  EXPECT_THAT(series_named(nis, "used").y, ElementsAre(1.5));
  EXPECT_THAT(series_named(nis, "rejected").x, ElementsAre(1.0));
  EXPECT_THAT(series_named(nis, "rejected").y, ElementsAre(30.0));
  std::size_t drawn = 0;
  for (const Series& series : nis.series) drawn += series.kind == SeriesKind::points ? series.x.size() : 0;
  EXPECT_EQ(drawn, 3U);
  // χ² of two dof: its quantile of 95 % is −2 ln 0.05.
  EXPECT_NEAR(series_named(nis, "95 % of a consistent filter lie below").y.at(0), -2.0 * std::log(0.05),
              1e-12);
  r.settings.filter.gate = 0.9;  // cut off there, 95 % of the rest lie below the quantile of 0.855
  const Figure gated = replay_run_figure("r", "c", r);
  EXPECT_NEAR(series_named(panel_named(gated, "NIS of single observations"),
                           "95 % of those used lie below if consistent")
                  .y.at(0),
              -2.0 * std::log(0.145), 1e-12);
}

TEST(ReplayFigures, TheMapHasPathSurveyAndAnchors) {
  ReplayResult r = short_replay();
  r.anchors = {0};
  const Panel panel = replay_map_panel("m", r);
  EXPECT_THAT(series_named(panel, "EKF-SLAM").x, ElementsAre(0.0, 1.0));
  EXPECT_THAT(series_named(panel, "surveyed").y, ElementsAre(20.0, 40.0));
  EXPECT_THAT(series_named(panel, "estimated").x, ElementsAre(30.5, 5.0));
  EXPECT_THAT(series_named(panel, "anchors").x, ElementsAre(10.0));
  EXPECT_THAT(series_named(panel, "anchors").y, ElementsAre(20.0));
  const Series& ellipses = series_named(panel, "2σ");
  EXPECT_NEAR(*std::ranges::max_element(ellipses.x), 31.5, 1e-9) << "2 σ of 0.5 m to the right";
  EXPECT_NO_THROW(replay_map_panel("m", {}));
}

TEST(ReplayFigures, AReplayWithoutAnythingHasFiguresThatCanBeDrawn) {
  for (const Figure& figure : replay_figures("empty", {})) EXPECT_NO_THROW(validate(figure)) << figure.name;
}

}  // namespace
}  // namespace credence::internal
