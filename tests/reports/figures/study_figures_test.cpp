#include "reports/figures/study_figures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

Scenario short_study(const char* world) {
  Scenario scenario = default_scenario(world);
  scenario.study.runs = 4;
  scenario.study.steps = 12;
  return scenario;
}

RunTrace run_of(const Scenario& scenario) { return make_experiment(scenario)->trace(0); }

const Series* find_series(const Panel& panel, const std::string& label) {
  const auto found =
      std::ranges::find_if(panel.series, [&](const Series& s) { return s.label.text == label; });
  return found == panel.series.end() ? nullptr : &*found;
}

/// The error curve is estimate − truth of state i, and both bounds are two deviations from zero.
void expect_errors(const Panel& panel, const RunTrace& trace, Index i, double unit, std::size_t first = 0) {
  ASSERT_GE(panel.series.size(), first + 3);
  const Series &lower = panel.series[first], &upper = panel.series[first + 1],
               &error = panel.series[first + 2];
  ASSERT_EQ(error.y.size(), trace.steps.size());
  for (std::size_t k = 0; k < trace.steps.size(); ++k) {
    const TraceStep& step = trace.steps[k];
    double difference = step.estimate[i] - step.truth[i];
    if (unit != 1.0) difference = std::remainder(difference, 2.0 * std::numbers::pi);
    EXPECT_NEAR(std::abs(error.y[k]), std::abs(unit * difference), 1e-9) << k;
    EXPECT_NEAR(upper.y[k], 2.0 * unit * std::sqrt(step.P(i, i)), 1e-9) << k;
    EXPECT_EQ(lower.y[k], -upper.y[k]);
  }
}

TEST(StudyFigures, OfAMonobotThePapersColumns) {
  Scenario scenario = short_study("monobot");
  scenario.world.landmarks = 2;
  const RunTrace trace = run_of(scenario);
  const Figure figure = monobot_run_figure("m", trace);
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 5U);
  expect_errors(figure.panels[3], trace, 0, 1.0);
  expect_errors(figure.panels[4], trace, 1, 1.0);
  expect_errors(figure.panels[4], trace, 2, 1.0, 3);
  const Panel& gains = figure.panels[2];
  ASSERT_EQ(gains.series.size(), 3U);
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    EXPECT_EQ(gains.series[0].y[k], trace.steps[k].K(0, 0));
    EXPECT_EQ(gains.series[1].y[k], trace.steps[k].K(1, 0));
    EXPECT_EQ(gains.series[2].y[k], trace.steps[k].K(2, 1)) << "by the measurement of its own landmark";
  }
  EXPECT_TRUE(std::isnan(gains.series[0].y[0])) << "no measurement at the start";
  const Series* measured = find_series(figure.panels[1], "measured");
  ASSERT_NE(measured, nullptr);
  EXPECT_NEAR(measured->y[3], trace.steps[3].estimate[0] + trace.steps[3].z[0], 1e-12);
}

TEST(StudyFigures, AnAnchorsMeasurementIsNoLandmarks) {
  Scenario scenario = short_study("monobot");
  scenario.world.landmarks = 1;
  scenario.world.anchors = 1;
  scenario.world.observability = Observability::full;
  const RunTrace trace = run_of(scenario);
  const Figure figure = monobot_run_figure("m", trace);
  EXPECT_NEAR(find_series(figure.panels[1], "measured")->y[3],
              trace.steps[3].estimate[0] + trace.steps[3].z[1], 1e-12);
  EXPECT_EQ(figure.panels[2].series[1].y[3], trace.steps[3].K(1, 1));
}

TEST(StudyFigures, InThePlaneTimeIsInSecondsAndHeadingInDegrees) {
  Scenario scenario = short_study("planar");
  scenario.world.landmarks = 3;
  const RunTrace trace = run_of(scenario);
  const Figure figure = planar_run_figure("p", trace, StepTimes::every(0.25).get());
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 4U);
  expect_errors(figure.panels[1], trace, 0, 1.0);
  expect_errors(figure.panels[3], trace, 2, 180.0 / std::numbers::pi);
  EXPECT_EQ(figure.panels[1].series[0].x.back(), 0.25 * 12);
  const Series* path = find_series(figure.panels[0], "true path");
  const Series* estimated = find_series(figure.panels[0], "estimated path");
  const Series* landmarks = find_series(figure.panels[0], "landmarks, true");
  ASSERT_TRUE(path && estimated && landmarks);
  EXPECT_EQ(path->x.back(), trace.steps.back().truth[0]);
  EXPECT_EQ(estimated->y.back(), trace.steps.back().estimate[1]);
  EXPECT_EQ(landmarks->x.size(), 3U);
}

// Beside the errors of the landmarks in the state stand the variances of the same, not of the whole map.
TEST(StudyFigures, RmseIsComparedWithWhatPClaimsOfTheSame) {
  Scenario scenario = short_study("planar");
  scenario.world.landmarks = 3;
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  StudyAnalysis analysis =
      analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {.threads = 1}).front()));
  analysis.bound = posterior_bound(scenario);
  const Figure figure = study_figures("p", analysis, std::nullopt).back();
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 3U);
  constexpr std::pair<Quantity, double> kClaims[] = {{Quantity::trace_vehicle, 1.0},
                                                     {Quantity::heading_variance, 180.0 / std::numbers::pi},
                                                     {Quantity::landmark_variance, 1.0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Series* claims = find_series(figure.panels[i], "P claims");
    ASSERT_NE(claims, nullptr);
    const auto [quantity, unit] = kClaims[i];
    const double last = analysis.statistics.steps.back()[quantity].mean;
    EXPECT_GT(last, 0.0);
    EXPECT_NEAR(claims->y[11], unit * std::sqrt(last), 1e-12) << i;
  }
  analysis.covariance.heading = analysis.covariance.landmark = {};
  const Figure of_old_store = study_figures("p", analysis, std::nullopt).back();
  EXPECT_NO_THROW(validate(of_old_store));
  EXPECT_EQ(find_series(of_old_store.panels[1], "P claims"), nullptr);
  EXPECT_NE(find_series(of_old_store.panels[0], "P claims"), nullptr);
}

TEST(StudyFigures, EllipsesTooSmallToBeSeenAreDrawnLarger) {
  RunTrace trace = run_of([] {
    Scenario scenario = short_study("planar");
    scenario.world.landmarks = 3;
    return scenario;
  }());
  double extent = 0.0;
  for (TraceStep& step : trace.steps) {
    step.P.setZero();
    for (Index i = 0; i < 2; ++i) {
      extent = std::max(extent, std::abs(step.truth[i] - trace.steps.front().truth[i]));
    }
  }
  for (TraceStep& step : trace.steps)
    step.P.topLeftCorner(2, 2).diagonal().setConstant(1e-6 * extent * extent);
  // 2σ is 0.002 of the largest distance from the start, which is the extent or down to half of it: times 20
  // it is 3 % of the first, times 50 of the second.
  const Figure figure = planar_run_figure("p", trace, StepTimes::every(1.0).get());
  const Series* drawn = find_series(figure.panels[0], "vehicle 2σ, 20×");
  if (drawn == nullptr) drawn = find_series(figure.panels[0], "vehicle 2σ, 50×");
  ASSERT_NE(drawn, nullptr);
  EXPECT_THAT(figure.caption, testing::HasSubstr("times as large"));
  for (TraceStep& step : trace.steps) step.P.topLeftCorner(2, 2) *= 1e4;
  EXPECT_NE(find_series(planar_run_figure("p", trace, StepTimes::every(1.0).get()).panels[0], "vehicle 2σ"),
            nullptr);
}

/// A run of blocks "b0", "b1", … of two states each, "b0.x" and "b0.y", …
RunTrace run_of_blocks(Index blocks) {
  RunTrace trace;
  for (Index k = 0; k < 3; ++k) {
    TraceStep step;
    step.truth = Vector::Zero(2 * blocks);
    step.estimate = step.error = Vector::LinSpaced(2 * blocks, 0.0, static_cast<double>(2 * blocks - 1));
    step.P = Matrix::Identity(2 * blocks, 2 * blocks);
    trace.steps.push_back(step);
  }
  for (Index i = 0; i < blocks; ++i) {
    for (const char* state : {".x", ".y"}) trace.layout.states.push_back("b" + std::to_string(i) + state);
  }
  trace.layout.angles.resize(trace.layout.states.size());
  add_named_blocks(trace.layout);
  return trace;
}

TEST(StudyFigures, AllStatesOfAnInertialFilterAreShown) {
  const Figure figure = states_run_figure("s", run_of_blocks(7));
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 14U);
  EXPECT_EQ(figure.panels.back().title.text, "b6.y");
  EXPECT_EQ(figure.rows, 5);
  EXPECT_EQ(figure.caption, "Run 0: errors with 2σ.");
}

TEST(StudyFigures, OfManyStatesThoseOfTheWorstBlocksComeFirst) {
  RunTrace trace = run_of_blocks(10);
  EXPECT_THAT(states_run_figure("s", trace).caption, testing::HasSubstr("of the first 15 of 20 states"));
  trace.layout.angles[18] = true;
  std::vector<BlockVerdict> blocks;
  for (int i = 0; i < 10; ++i) blocks.push_back({.name = "b" + std::to_string(i), .verdict = {}});
  blocks[9].verdict = {
      .verdict = Verdict::optimistic, .p_value = 0.0, .mean = 3.0, .expected = 1.0, .dof = 10.0};
  blocks[4].verdict = {.verdict = Verdict::mixed, .p_value = 1e-3, .mean = 1.0, .expected = 1.0, .dof = 10.0};
  const Figure figure = states_run_figure("s", trace, blocks);
  EXPECT_NO_THROW(validate(figure));
  std::vector<std::string> titles;
  for (const Panel& panel : figure.panels) titles.push_back(panel.title.text);
  titles.resize(6);
  EXPECT_THAT(titles, ElementsAre("b9.x", "b9.y", "b4.x", "b4.y", "b0.x", "b0.y"));
  EXPECT_EQ(figure.panels.size(), 15U);
  EXPECT_THAT(figure.caption, testing::HasSubstr("of 15 of 20 states, those of inconsistent blocks first"));
  EXPECT_EQ(figure.panels[1].series.at(2).y[0], 19.0);
  EXPECT_NEAR(figure.panels[0].series.at(2).y[0], 18.0 * 180.0 / std::numbers::pi, 1e-9);
  EXPECT_EQ(figure.panels[0].y_label.text, "error (°)");
}

TEST(StudyFigures, AVerdictHasItsStepsInTheirPlaces) {
  ConsistencyVerdict verdict;
  verdict.confidence = 0.9;
  verdict.step_stride = 5;
  verdict.steps = {{.mean = 2.5,
                    .expected = 2.0,
                    .lower = 1.5,
                    .upper = 2.75,
                    .simultaneous_lower = 1.25,
                    .simultaneous_upper = 3.0,
                    .count = 10,
                    .total_dof = 20.0},
                   {.mean = 0.0, .count = 0},
                   {.mean = 1.0,
                    .expected = 2.0,
                    .lower = 1.5,
                    .upper = 2.75,
                    .simultaneous_lower = 1.25,
                    .simultaneous_upper = 3.0,
                    .count = 10,
                    .total_dof = 20.0}};
  const Panel panel = verdict_panel("NEES", "mean NEES", verdict, {2.0, 2.0});
  EXPECT_NO_THROW(validate({.name = "v", .panels = {panel}}));
  const Series* mean = find_series(panel, "measured mean");
  EXPECT_THAT(mean->x, ElementsAre(1.0, 6.0, 11.0));
  EXPECT_EQ(mean->y[0], 2.5);
  EXPECT_TRUE(std::isnan(mean->y[1])) << "no data is no zero";
  const Series* band = find_series(panel, "90 % of single steps");
  ASSERT_NE(band, nullptr);
  EXPECT_EQ(band->upper[2], 2.75);
  EXPECT_EQ(find_series(panel, "all steps together")->y[0], 1.25);
  EXPECT_EQ(find_series(panel, "exact")->y.size(), 2U);
  EXPECT_EQ(find_series(verdict_panel("", "", verdict, {}), "exact"), nullptr);
  EXPECT_FALSE(panel.log_y);
  ConsistencyVerdict diverged = verdict;
  diverged.steps[0].mean = 1e9;
  const Panel far = verdict_panel("NEES", "mean NEES", diverged, {});
  EXPECT_NO_THROW(validate({.name = "v", .panels = {far}}));
  EXPECT_TRUE(far.log_y) << "the bounds would lie on the axis";
  EXPECT_LT(far.y_range->low, 1.0);
  EXPECT_GT(far.y_range->high, 1e9);
  // Of a sensor that is slower than the steps, values with gaps between would be no line.
  verdict.steps.insert(verdict.steps.begin() + 1, 1, StepTest{});
  EXPECT_EQ(find_series(verdict_panel("", "", verdict, {}), "measured mean")->x.size(), 2U)
      << "of every second";
  verdict.steps.insert(verdict.steps.begin() + 1, 1, StepTest{});
  const Panel sparse = verdict_panel("NIS of gps", "mean NIS", verdict, {});
  EXPECT_NO_THROW(validate({.name = "v", .panels = {sparse}}));
  EXPECT_THAT(find_series(sparse, "measured mean")->x, ElementsAre(1.0, 21.0));
  EXPECT_THAT(find_series(sparse, "measured mean")->y, ElementsAre(2.5, 1.0));
}

ConsistencyVerdict verdict_over_steps(const std::vector<double>& means, const std::vector<double>& dofs) {
  ConsistencyVerdict verdict;
  for (std::size_t k = 0; k < means.size(); ++k) {
    const double dof = dofs[k % dofs.size()];
    verdict.steps.push_back({.mean = means[k],
                             .expected = dof,
                             .lower = 0.75 * dof,
                             .upper = 1.25 * dof,
                             .simultaneous_lower = 0.5 * dof,
                             .simultaneous_upper = 1.5 * dof,
                             .count = 10,
                             .total_dof = 10.0 * dof});
  }
  return verdict;
}

TEST(StudyFigures, WhereTheDofGoesUpAndDownMeansAreShownOverIt) {
  const Panel panel =
      verdict_panel("NIS", "mean NIS", verdict_over_steps({4.0, 8.0, 6.0, 8.0}, {4.0, 8.0}), {});
  EXPECT_EQ(panel.y_label.text, "mean NIS over dof");
  EXPECT_THAT(find_series(panel, "measured mean")->y, ElementsAre(1.0, 1.0, 1.5, 1.0));
  EXPECT_THAT(find_series(panel, "expected")->y, ElementsAre(1.0, 1.0, 1.0, 1.0));
  EXPECT_THAT(find_series(panel, "all steps together")->y, ElementsAre(0.5, 0.5, 0.5, 0.5));
  const Panel grows = verdict_panel(
      "NEES", "mean NEES", verdict_over_steps(std::vector<double>(8, 4.0), {4, 4, 4, 4, 6, 6, 6, 6}), {});
  EXPECT_EQ(grows.y_label.text, "mean NEES") << "a map that grows";
}

TEST(StudyFigures, MeansFarBelowTheirBoundsAreNoLineOnZero) {
  const Panel low = verdict_panel("NIS", "mean NIS", verdict_over_steps({0.002, 0.004, 0.003}, {2.0}), {});
  EXPECT_NO_THROW(validate({.name = "v", .panels = {low}}));
  EXPECT_TRUE(low.log_y);
  EXPECT_LT(low.y_range.value().low, 0.002);
  EXPECT_GT(low.y_range.value().high, 3.0);
  // NIS of 0.135 of 2 under bounds of 22, as of a replay.
  EXPECT_TRUE(verdict_panel("NIS", "mean NIS", verdict_over_steps({0.1, 0.2, 0.105}, {2.0}), {}).log_y);
  // One small value among others is not.
  EXPECT_FALSE(verdict_panel("NIS", "mean NIS", verdict_over_steps({0.002, 2.0, 3.0}, {2.0}), {}).log_y);
}

TEST(StudyFigures, MeansThatALogarithmicAxisCutsOffAreTold) {
  const auto caption = [](const std::vector<double>& means) {
    Figure figure{.name = "v",
                  .caption = "C.",
                  .panels = {verdict_panel("NIS", "mean NIS", verdict_over_steps(means, {2.0}), {})}};
    tell_cut_means(figure);
    return figure.caption;
  };
  EXPECT_EQ(caption({0.002, 0.004, 0.003}), "C.");
  EXPECT_EQ(caption({0.002, 1e-9, 0.003}), "C. Means below a logarithmic axis are cut off.");
  EXPECT_EQ(caption({0.0, 2.0, 3.0}), "C.") << "a linear axis";
  EXPECT_EQ(caption({1e6, 0.05, 3.0}), "C.") << "the axis of means far above reaches down to others";
  EXPECT_EQ(caption({1e6, 1e-6, 3.0}), "C. Means below a logarithmic axis are cut off.");
}

TEST(StudyFigures, ErrorsHaveTheUnitOfTheirState) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  EXPECT_EQ(error_unit("m").label, "error (m)");
  EXPECT_EQ(error_unit("m").scale, 1.0);
  EXPECT_EQ(error_unit("m/s").label, "error (m/s)");
  EXPECT_EQ(error_unit("m/s").scale, 1.0);
  EXPECT_EQ(error_unit("rad").label, "error (°)");
  EXPECT_NEAR(error_unit("rad").scale, kDegrees, 1e-12);
  EXPECT_EQ(error_unit("rad/s").label, "error (°/s)");
  EXPECT_NEAR(error_unit("rad/s").scale, kDegrees, 1e-12);
  EXPECT_EQ(error_unit("").label, "error") << "not known";
  EXPECT_EQ(error_unit("").scale, 1.0);
}

// The layout says them, whatever the parts of the blocks are.
TEST(StudyFigures, AxesOfErrorsHaveTheUnitsOfTheLayout) {
  const auto labels = [](const Figure& figure) {
    std::vector<std::string> all;
    for (const Panel& panel : figure.panels) all.push_back(panel.y_label.text);
    return all;
  };
  EXPECT_THAT(labels(states_run_figure("t", run_of(short_study("tracking")))),
              ElementsAre("error (m)", "error (m)", "error (m/s)", "error (m/s)"));
  const RunTrace swing = run_of(short_study("pendulum"));
  const Figure figure = states_run_figure("p", swing);
  EXPECT_THAT(labels(figure), ElementsAre("error (°)", "error (°/s)"));
  EXPECT_NEAR(figure.panels[1].series.at(2).y.at(5), 180.0 / std::numbers::pi * swing.steps.at(5).error[1],
              1e-12);
  RunTrace unknown = run_of_blocks(1);
  unknown.layout.blocks[0].part = Part::position;
  EXPECT_THAT(labels(states_run_figure("u", unknown)), ElementsAre("error", "error"));
  unknown.layout.units = {"", "ft"};
  EXPECT_THAT(labels(states_run_figure("u", unknown)), ElementsAre("error", "error (ft)"));
}

TEST(StudyFigures, ATraceThatWouldSumSeveralUnitsIsNotDrawn) {
  for (const char* world : {"tracking", "pendulum"}) {
    const Scenario scenario = short_study(world);
    const auto experiment = make_experiment(scenario);
    const StudyTask task{"", experiment.get(), scenario.study.runs};
    const StudyAnalysis analysis =
        analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {.threads = 1}).front()));
    const Panel traces = consistency_figure("s", analysis).panels.back();
    const bool has_position = !analysis.covariance.vehicle.empty();
    EXPECT_EQ(find_series(traces, "position") != nullptr, has_position) << world;
    EXPECT_EQ(find_series(traces, "all states") != nullptr, !has_position) << world;
    EXPECT_EQ(has_position, std::string(world) == "tracking");
  }
}

TEST(StudyFigures, EveryWorldHasFiguresThatCanBeDrawnAlsoOfRunsThatAllFailed) {
  for (const char* world : {"monobot", "planar", "pendulum"}) {
    const Scenario scenario = short_study(world);
    const auto experiment = make_experiment(scenario);
    const StudyTask task{"", experiment.get(), scenario.study.runs};
    StudyAnalysis analysis =
        analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {.threads = 1}).front()));
    for (const Figure& figure : study_figures("s", analysis, experiment->trace(0))) {
      if (!figure.panels.empty()) EXPECT_NO_THROW(validate(figure)) << world << figure.name;
    }
    const Figure consistency = consistency_figure("s", analysis);
    EXPECT_EQ(find_series(consistency.panels.at(0), "measured mean")->y.size(), 12U);
    EXPECT_EQ(find_series(consistency.panels[1], "measured mean")->y[4], analysis.nis.steps[4].mean);
  }
}

}  // namespace
}  // namespace credence::internal
