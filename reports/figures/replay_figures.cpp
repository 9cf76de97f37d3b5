#include "reports/figures/replay_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/manifold/angle.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

bool has_heading(const ReplayResult& r) { return !r.references.empty() && r.references.front().dof == 3; }

const char* reference_name(const ReplayResult& r) { return has_heading(r) ? "motion capture" : "GPS"; }

/// Error of one coordinate of the vehicle against the reference, with 2σ of the filter.
Panel vehicle_panel(const ReplayResult& r, Index i, const char* title) {
  const double scale = i == 2 ? 1.0 / kRadiansPerDegree : 1.0;
  Panel panel{.title = title, .x_label = "time (s)", .y_label = i == 2 ? "error (°)" : "error (m)"};
  FigureData t, error, lower, upper;
  for (const ReplayReference& ref : r.references) {
    double e = ref.estimate[i] - ref.truth[i];
    if (i == 2) e = wrap_angle(e);
    const double two_sigma = 2.0 * scale * std::sqrt(ref.covariance(i, i));
    t.push_back(ref.time_s);
    error.push_back(scale * e);
    lower.push_back(-two_sigma);
    upper.push_back(two_sigma);
  }
  panel.series.push_back(line_series("±2σ", ColourRole::bound, t, lower));
  panel.series.push_back(line_series("", ColourRole::bound, t, upper));
  panel.series.push_back(line_series("error", ColourRole::estimate, t, error));
  return panel;
}

/// A curve for each landmark over the steps; `get` is given the landmark and its surveyed place.
template <class Get>
std::map<int, std::pair<FigureData, FigureData>> landmark_curves(const ReplayResult& r, Get get) {
  std::map<int, std::pair<FigureData, FigureData>> curves;
  for (const ReplayStep& step : r.steps) {
    for (const ReplayLandmark& landmark : step.landmarks) {
      if (landmark.landmark < 0) continue;
      auto& [t, value] = curves[landmark.landmark];
      t.push_back(step.time_s);
      value.push_back(get(landmark, r.survey_m[static_cast<std::size_t>(landmark.landmark)]));
    }
  }
  return curves;
}

/// How a landmark is drawn in every panel: six colours, then the same dashed and dotted.
Series landmark_line(int landmark, FigureText label, FigureData t, FigureData value) {
  constexpr std::array strokes{StrokeStyle::solid, StrokeStyle::dashed, StrokeStyle::dotted};
  Series series = line_series(std::move(label), numbered_role(landmark), std::move(t), std::move(value));
  series.stroke = strokes[static_cast<std::size_t>(landmark / 6) % strokes.size()];
  return series;
}

/// Landmarks are numbered from 1 in the order of the survey.
std::string landmark_name(int landmark) { return fmt::format("{}", landmark + 1); }

/// Errors of all landmarks in one coordinate, each over its 2σ in the same colour.
Panel landmark_panel(const ReplayResult& r, Index i, const char* title) {
  Panel panel{.title = title, .x_label = "time (s)", .y_label = "error (m)"};
  for (const double sign : {-2.0, 2.0}) {
    const auto bounds = landmark_curves(r, [&](const ReplayLandmark& landmark, const Point&) {
      return sign * std::sqrt(landmark.covariance(i, i));
    });
    for (const auto& [id, curve] : bounds) {
      Series series = landmark_line(id, "", curve.first, curve.second);
      series.weight = 0.4;
      panel.series.push_back(std::move(series));
    }
  }
  const auto errors = landmark_curves(r, [&](const ReplayLandmark& landmark, const Point& surveyed) {
    return landmark.position[i] - surveyed[i];
  });
  for (const auto& [id, curve] : errors)
    panel.series.push_back(landmark_line(id, landmark_name(id), curve.first, curve.second));
  return panel;
}

/// Norms of the rows of K of the vehicle's position and of each landmark.
template <class Get>
Panel gain_panel(const ReplayResult& r, const char* title, const char* y_label, Get get) {
  Panel panel{.title = title, .x_label = "time (s)", .y_label = y_label};
  const auto curves =
      landmark_curves(r, [&](const ReplayLandmark& landmark, const Point&) { return get(landmark.gain); });
  for (const auto& [id, curve] : curves)
    panel.series.push_back(landmark_line(id, "", curve.first, curve.second));
  FigureData t, vehicle;
  for (const ReplayStep& step : r.steps) {
    t.push_back(step.time_s);
    vehicle.push_back(get(step.gain));
  }
  panel.series.push_back(line_series("vehicle position", ColourRole::neutral, t, vehicle));
  return panel;
}

Panel trace_panel(const ReplayResult& r) {
  Panel panel{
      .title = "Traces of the covariance", .x_label = "time (s)", .y_label = "trace (m²)", .log_y = true};
  FigureData t, vehicle, landmarks;
  for (const ReplayStep& step : r.steps) {
    t.push_back(step.time_s);
    vehicle.push_back(step.covariance(0, 0) + step.covariance(1, 1));
    double sum = 0.0;
    for (const ReplayLandmark& landmark : step.landmarks) sum += landmark.covariance.trace();
    landmarks.push_back(sum > 0.0 ? sum : kNaN);
  }
  panel.series.push_back(line_series("vehicle position", ColourRole::first, t, vehicle));
  panel.series.push_back(line_series("all landmarks", ColourRole::second, t, landmarks));
  return panel;
}

Panel nis_panel(const ReplayResult& r) {
  Panel panel{
      .title = "NIS of single observations", .x_label = "time (s)", .y_label = "NIS (2 dof)", .log_y = true};
  constexpr double kFloor = 1e-4;  // a logarithmic axis has no zero
  FigureData t, used, low_t, rejected_t, rejected;
  for (const ReplayObservation& observation : r.records) {
    if (observation.outcome == ObservationOutcome::rejected) {
      rejected_t.push_back(observation.time_s);
      rejected.push_back(std::max(kFloor, observation.nis));
    } else if (observation.outcome == ObservationOutcome::updated && observation.nis < kFloor) {
      low_t.push_back(observation.time_s);
    } else if (observation.outcome == ObservationOutcome::updated) {
      t.push_back(observation.time_s);
      used.push_back(observation.nis);
    }
  }
  panel.series.push_back(point_series("used", ColourRole::estimate, t, used));
  if (!low_t.empty()) {
    panel.series.push_back(point_series(figure_markup("used, below 10^{−4}"), ColourRole::neutral, low_t,
                                        FigureData(low_t.size(), kFloor)));
    panel.series.back().marker = MarkerShape::triangle;
  }
  if (!rejected.empty())
    panel.series.push_back(point_series("rejected", ColourRole::alarm, rejected_t, rejected));
  panel.series.push_back(
      level_series("95 % of a consistent filter lie below", ColourRole::bound, gate_threshold(0.95)));
  return panel;
}

}  // namespace

Panel replay_map_panel(const std::string& title, const ReplayResult& r) {
  Panel panel{.title = title, .x_label = "east x (m)", .y_label = "north y (m)", .equal_aspect = true};
  if (has_heading(r)) panel.x_label = "x (m)", panel.y_label = "y (m)";
  FigureData x, y, reference_x, reference_y, survey_x, survey_y, map_x, map_y;
  std::vector<FigureText> names;
  for (const ReplayStep& step : r.steps) {
    x.push_back(step.pose[0]);
    y.push_back(step.pose[1]);
  }
  for (const ReplayReference& ref : r.references) {
    reference_x.push_back(ref.truth[0]);
    reference_y.push_back(ref.truth[1]);
  }
  for (const Point& p : r.survey_m) {
    survey_x.push_back(p[0]);
    survey_y.push_back(p[1]);
    names.emplace_back(landmark_name(static_cast<int>(names.size())));
  }
  PlanarCurve ellipses;
  for (const ReplayLandmark& landmark : r.map) {
    map_x.push_back(landmark.position[0]);
    map_y.push_back(landmark.position[1]);
    append_curve(ellipses, ellipse_points(landmark.position, landmark.covariance, 2.0));
  }
  panel.series.push_back(line_series(reference_name(r), ColourRole::truth, reference_x, reference_y));
  panel.series.push_back(line_series("EKF-SLAM", ColourRole::estimate, x, y));
  panel.series.push_back(polygon_series("2σ", ColourRole::bound, ellipses.x, ellipses.y));
  panel.series.push_back(point_series("surveyed", ColourRole::truth, survey_x, survey_y));
  panel.series.push_back(text_series(ColourRole::truth, survey_x, survey_y, std::move(names)));
  panel.series.push_back(point_series("estimated", ColourRole::estimate, map_x, map_y));
  if (!r.anchors.empty()) {
    FigureData anchor_x, anchor_y;
    for (const int anchor : r.anchors) {
      anchor_x.push_back(r.survey_m[static_cast<std::size_t>(anchor)][0]);
      anchor_y.push_back(r.survey_m[static_cast<std::size_t>(anchor)][1]);
    }
    Series anchors = point_series("anchors", ColourRole::exact, anchor_x, anchor_y);
    anchors.marker = MarkerShape::square;
    panel.series.push_back(std::move(anchors));
  }
  return panel;
}

Figure replay_run_figure(const std::string& name, const std::string& caption, const ReplayResult& r) {
  Figure figure{.name = name, .caption = caption, .rows = 4, .cols = 2};
  figure.panels = {
      vehicle_panel(r, 0, "Vehicle error in x"),
      vehicle_panel(r, 1, "Vehicle error in y"),
      landmark_panel(r, 0, "Landmark errors in x"),
      landmark_panel(r, 1, "Landmark errors in y"),
      gain_panel(r, "Gain of the range", "‖K‖ (m/m)", [](const ReplayGain& g) { return g.range; }),
      gain_panel(r, "Gain of the bearing", "‖K‖ (m/rad)", [](const ReplayGain& g) { return g.bearing; }),
      trace_panel(r),
      nis_panel(r)};
  if (has_heading(r)) {
    figure.rows = 5;
    figure.panels.insert(figure.panels.begin() + 2, vehicle_panel(r, 2, "Vehicle error in heading"));
  }
  return figure;
}

std::vector<Figure> replay_figures(const std::string& name, const ReplayResult& r) {
  const std::string reference = reference_name(r);
  const Figure map{.name = name + "-map",
                   .caption = "Estimated path and map over " + reference +
                              " and the survey; ellipses are 2σ of the final map.",
                   .panels = {replay_map_panel("Path and map", r)}};
  return {map,
          replay_run_figure(name + "-run",
                            "Errors of the vehicle against " + reference +
                                " and of the landmarks, by number, against the survey, each with the "
                                "filter's 2σ (thin, of a landmark in its colour); gains: norms of the rows "
                                "of K by kind of measurement, landmarks in the same colours; traces; NIS.",
                            r)};
}

}  // namespace credence::internal
