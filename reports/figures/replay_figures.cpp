#include "reports/figures/replay_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "core/manifold/angle.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

const char* reference_name(const ReplayResult& r) { return has_true_heading(r) ? "motion capture" : "GPS"; }

/// Error of one coordinate of the vehicle against the reference, with 2σ of the filter.
Panel vehicle_panel(const ReplayResult& r, Index i, const char* title) {
  const double scale = i == 2 ? 1.0 / kRadiansPerDegree : 1.0;
  Panel panel{.title = title, .x_label = "time (s)", .y_label = i == 2 ? "error (°)" : "error (m)"};
  const auto error = [&](const ReplayReference& ref) {
    const double e = ref.estimate[i] - ref.truth[i];
    return scale * (i == 2 ? wrap_angle(e) : e);
  };
  const auto two_sigma = [&](const ReplayReference& ref) {
    return 2.0 * scale * std::sqrt(ref.covariance(i, i));
  };
  panel.series =
      error_series("error", ColourRole::estimate, figure_data(r.references, &ReplayReference::time_s),
                   figure_data(r.references, error), figure_data(r.references, two_sigma));
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

/// 2σ of the landmarks in one coordinate over the steps: a band for each sign from the smallest to the
/// largest, and the median.
std::vector<Series> landmark_bounds(const ReplayResult& r, Index i) {
  FigureData t, least, median, largest;
  for (const ReplayStep& step : r.steps) {
    std::vector<double> bounds;
    for (const ReplayLandmark& landmark : step.landmarks) {
      if (landmark.landmark >= 0) bounds.push_back(2.0 * std::sqrt(landmark.covariance(i, i)));
    }
    if (bounds.empty()) continue;
    std::ranges::sort(bounds);
    t.push_back(step.time_s);
    least.push_back(bounds.front());
    median.push_back(0.5 * (bounds[(bounds.size() - 1) / 2] + bounds[bounds.size() / 2]));
    largest.push_back(bounds.back());
  }
  const auto below = [](const FigureData& values) { return figure_data(values, std::negate<>()); };
  constexpr ColourRole kRole = ColourRole::neutral;  // the others are those of landmarks
  return {band_series("±2σ, smallest to largest", kRole, t, least, largest),
          band_series("", kRole, t, below(largest), below(least)),
          line_series("±2σ, median", kRole, t, below(median)), line_series("", kRole, t, median)};
}

/// Errors of all landmarks in one coordinate over the bounds of all; each is thick where it is beyond its
/// own.
Panel landmark_panel(const ReplayResult& r, Index i, const char* title) {
  Panel panel{.title = title, .x_label = "time (s)", .y_label = "error (m)"};
  panel.series = landmark_bounds(r, i);
  const auto error = [i](const ReplayLandmark& landmark, const Point& surveyed) {
    return landmark.position[i] - surveyed[i];
  };
  const auto errors = landmark_curves(r, error);
  const auto beyond = landmark_curves(r, [&](const ReplayLandmark& landmark, const Point& surveyed) {
    const double e = error(landmark, surveyed);
    return std::abs(e) > 2.0 * std::sqrt(landmark.covariance(i, i)) ? e : kNaN;
  });
  for (const auto& [id, curve] : errors) {
    panel.series.push_back(landmark_line(id, landmark_name(id), curve.first, curve.second));
    const FigureData& outside = beyond.at(id).second;
    if (std::ranges::all_of(outside, [](double e) { return std::isnan(e); })) continue;
    panel.series.push_back(landmark_line(id, "", curve.first, outside));
    panel.series.back().weight = 2.0;
  }
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
  panel.series.push_back(
      line_series("vehicle position", ColourRole::neutral, figure_data(r.steps, &ReplayStep::time_s),
                  figure_data(r.steps, [&](const ReplayStep& step) { return get(step.gain); })));
  return panel;
}

Panel trace_panel(const ReplayResult& r) {
  Panel panel{
      .title = "Traces of the covariance", .x_label = "time (s)", .y_label = "trace (m²)", .log_y = true};
  const auto vehicle = [](const ReplayStep& step) { return step.covariance(0, 0) + step.covariance(1, 1); };
  const auto landmarks = [](const ReplayStep& step) {
    double sum = 0.0;
    for (const ReplayLandmark& landmark : step.landmarks) sum += landmark.covariance.trace();
    return sum > 0.0 ? sum : kNaN;
  };
  const FigureData t = figure_data(r.steps, &ReplayStep::time_s);
  panel.series = {line_series("vehicle position", ColourRole::first, t, figure_data(r.steps, vehicle)),
                  line_series("all landmarks", ColourRole::second, t, figure_data(r.steps, landmarks))};
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
  constexpr double kBelow = 0.95;
  const double gate = r.settings.filter.gate;  // what passes it follows the law that is cut off there
  panel.series.push_back(level_series(
      gate > 0.0 ? "95 % of those used lie below if consistent" : "95 % of a consistent filter lie below",
      ColourRole::bound, gate_threshold(gate > 0.0 ? kBelow * gate : kBelow)));
  return panel;
}

}  // namespace

Panel replay_map_panel(const std::string& title, const ReplayResult& r) {
  Panel panel{.title = title, .x_label = "east x (m)", .y_label = "north y (m)", .equal_aspect = true};
  if (has_true_heading(r)) panel.x_label = "x (m)", panel.y_label = "y (m)";
  // Coordinate 0 or 1 of places, or of what has one.
  const auto coordinates = [](Index i, const auto& items, auto place) {
    return figure_data(items, [&](const auto& item) { return std::invoke(place, item)[i]; });
  };
  const auto add = [&](auto series, FigureText label, ColourRole role, const auto& items, auto place) {
    panel.series.push_back(
        series(std::move(label), role, coordinates(0, items, place), coordinates(1, items, place)));
  };
  std::vector<FigureText> names;
  for (std::size_t i = 0; i < r.survey_m.size(); ++i) names.emplace_back(landmark_name(static_cast<int>(i)));
  PlanarCurve ellipses;
  for (const ReplayLandmark& landmark : r.map)
    append_curve(ellipses, ellipse_points(landmark.position, landmark.covariance, 2.0));
  const auto surveyed = [](const Point& p) { return p; };
  add(line_series, reference_name(r), ColourRole::truth, r.references, &ReplayReference::truth);
  add(line_series, "EKF-SLAM", ColourRole::estimate, r.steps, &ReplayStep::pose);
  panel.series.push_back(polygon_series("2σ", ColourRole::bound, ellipses.x, ellipses.y));
  add(point_series, "surveyed", ColourRole::truth, r.survey_m, surveyed);
  panel.series.push_back(text_series(ColourRole::truth, coordinates(0, r.survey_m, surveyed),
                                     coordinates(1, r.survey_m, surveyed), std::move(names)));
  add(point_series, "estimated", ColourRole::estimate, r.map, &ReplayLandmark::position);
  if (!r.anchors.empty()) {
    add(point_series, "anchors", ColourRole::exact, r.anchors,
        [&](int anchor) { return r.survey_m[static_cast<std::size_t>(anchor)]; });
    panel.series.back().marker = MarkerShape::square;
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
      gain_panel(r, "Gain of the range", "|K| (m/m)", [](const ReplayGain& g) { return g.range; }),
      gain_panel(r, "Gain of the bearing", "|K| (m/rad)", [](const ReplayGain& g) { return g.bearing; }),
      trace_panel(r),
      nis_panel(r)};
  if (has_true_heading(r)) {
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
                                " with the filter's 2σ, and of the landmarks, by number, against the "
                                "survey: thick where one is beyond its own 2σ, over the band from the "
                                "smallest to the largest 2σ of all and their median; gains: norms of the "
                                "rows of K by kind of measurement, landmarks in the same colours; traces; "
                                "NIS.",
                            r)};
}

}  // namespace credence::internal
