#include "reports/figures/estimator_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "montecarlo/worlds/registry.h"
#include "reports/figures/step_axis.h"

namespace credence::internal {
namespace {

constexpr std::size_t kPose = static_cast<std::size_t>(EstimatorBlock::pose);

/// The series of an estimator. The yardstick has a colour of its own; the others go by their number, and of
/// those that have the same one lines and markers differ.
Series drawn_as(const EstimatorStudy& study, std::size_t i, Series series) {
  series.role = ColourRole::truth;
  if (study.rows[i].name == "ideal") return series;
  Index number = 0;
  for (std::size_t j = 0; j < i; ++j) number += study.rows[j].name == "ideal" ? 0 : 1;
  constexpr std::array kShapes = {MarkerShape::dot,     MarkerShape::square, MarkerShape::triangle,
                                  MarkerShape::diamond, MarkerShape::plus,   MarkerShape::cross};
  constexpr std::array kStrokes = {StrokeStyle::solid, StrokeStyle::dashed, StrokeStyle::dotted};
  const Index round = number / kNumberedRoles;
  series.role = numbered_role(number);
  series.stroke = kStrokes[static_cast<std::size_t>(round) % kStrokes.size()];
  series.marker = kShapes[static_cast<std::size_t>(number + 2 * round) % kShapes.size()];
  return series;
}

/// "3: fej": every estimator has its number in all panels.
std::string numbered(const EstimatorStudy& study, std::size_t i) {
  return fmt::format("{}: {}", i + 1, study.rows[i].name);
}

bool has_runs(const EstimatorRow& row) { return row.runs > 1; }

double finite_upper(const MeanInterval& interval) {
  return std::isfinite(interval.upper) ? interval.upper : interval.mean;
}
/// On a logarithmic axis.
double positive_lower(const MeanInterval& interval) {
  return interval.lower > 0.0 ? interval.lower : interval.mean;
}

std::string nees_label(const EstimatorStudy& study) {
  return study.has_vehicle ? "pose NEES over dof" : "NEES over dof";
}

/// NEES with its interval against a number of each estimator.
Panel against(const EstimatorStudy& study, Panel panel, double (*abscissa)(const EstimatorRow&)) {
  panel.y_label = nees_label(study);
  panel.log_y = true;
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    const EstimatorRow& row = study.rows[i];
    if (!has_runs(row)) continue;
    const MeanInterval& nees = row.nees[kPose];
    panel.series.push_back(drawn_as(study, i,
                                    error_bar_series(numbered(study, i), {}, {abscissa(row)}, {nees.mean},
                                                     {positive_lower(nees)}, {finite_upper(nees)})));
    panel.series.push_back(
        drawn_as(study, i, text_series({}, {abscissa(row)}, {nees.mean}, {fmt::to_string(i + 1)})));
  }
  return panel;
}

Panel over_time(const EstimatorStudy& study) {
  const auto times = StepTimes::every(step_s(study.scenario));
  const FigureData ends = figure_data(study.window_ends, [&](double step) {
    return step_place(times.get(), static_cast<std::int64_t>(step));
  });
  Panel panel{
      .title = "Over time", .x_label = step_label(times.get()), .y_label = nees_label(study), .log_y = true};
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    if (!has_runs(study.rows[i])) continue;
    panel.series.push_back(
        drawn_as(study, i, line_series(numbered(study, i), {}, ends, study.rows[i].pose_nees)));
  }
  return panel;
}

/// Median, quartiles and the middle nine tenths of the runs, one estimator beside the other.
Panel over_runs(const EstimatorStudy& study) {
  Panel panel{.title = "Over the runs",
              .x_label = "estimator",
              .y_label = nees_label(study) + " of a run",
              .x_range = AxisRange{0.5, static_cast<double>(study.rows.size()) + 0.5},
              .log_y = true};
  for (std::size_t i = 1; i <= study.rows.size(); ++i) panel.x_names.push_back(fmt::to_string(i));
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    if (!has_runs(study.rows[i])) continue;
    const Band& band = study.rows[i].bands[kPose];
    const double x = static_cast<double>(i) + 1.0;
    Series quartiles = drawn_as(study, i, line_series("", {}, {x, x}, {band[1], band[3]}));
    quartiles.weight = 4.0;
    quartiles.stroke = StrokeStyle::solid;
    panel.series.push_back(std::move(quartiles));
    panel.series.push_back(
        drawn_as(study, i, error_bar_series(numbered(study, i), {}, {x}, {band[2]}, {band[0]}, {band[4]})));
  }
  return panel;
}

}  // namespace

std::vector<Figure> estimator_figures(const EstimatorStudy& study) {
  if (std::ranges::none_of(study.rows, has_runs)) return {};
  Figure figure{
      .name = "estimators",
      .caption = fmt::format(
          "NEES of the {} over its dof, in the chart of each estimator's own P. Above: its mean over the "
          "runs with its {:g} % interval, against accuracy and against cost: left is better, on the line "
          "is consistent, above it optimistic. Below: the mean over the runs, in windows of steps; and "
          "median, quartiles (thick) and the middle 90 % (thin) of the averages of single runs.",
          study.has_vehicle ? "pose" : "state", 100.0 * study.scenario.study.confidence),
      .rows = 2,
      .cols = 2};
  figure.panels.push_back(
      against(study,
              {.title = "Consistency and accuracy",
               .x_label = study.has_vehicle ? "RMSE of position (m)" : "RMSE of the state",
               .log_x = true},
              [](const EstimatorRow& row) { return row.position_rmse_m.mean; }));
  figure.panels.push_back(
      against(study, {.title = "Consistency and cost", .x_label = "time per step (µs)", .log_x = true},
              [](const EstimatorRow& row) { return 1e6 * row.profile.seconds_per_step; }));
  figure.panels.push_back(over_time(study));
  figure.panels.push_back(over_runs(study));
  return {figure};
}

}  // namespace credence::internal
