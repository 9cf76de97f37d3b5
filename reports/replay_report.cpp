#include "reports/replay_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/angle.h"
#include "core/nan.h"
#include "reports/atomic_file.h"
#include "reports/gnuplot.h"
#include "reports/html_page.h"
#include "reports/json_numbers.h"
#include "reports/number_text.h"

namespace credence {
namespace {

bool has_heading_truth(const ReplayResult& r) {
  return !r.references.empty() && r.references.front().dof == 3;
}

Json mean_json(const ReplayMean& mean) {
  return {{"mean", mean.count > 0 ? json_number(mean.mean()) : Json(nullptr)},
          {"expected", json_number(mean.expected)},
          {"count", mean.count}};
}

Panel map_panel(const ReplayResult& r) {
  Panel panel{
      .title = "Path and map", .x_label = "east x (m)", .y_label = "north y (m)", .equal_aspect = true};
  FigureData x, y, reference_x, reference_y, survey_x, survey_y, map_x, map_y;
  for (const ReplayStep& s : r.steps) {
    x.push_back(s.pose[0]);
    y.push_back(s.pose[1]);
  }
  for (const ReplayReference& ref : r.references) {
    reference_x.push_back(ref.truth[0]);
    reference_y.push_back(ref.truth[1]);
  }
  for (const Point& p : r.survey_m) {
    survey_x.push_back(p[0]);
    survey_y.push_back(p[1]);
  }
  PlanarCurve ellipses;
  for (const ReplayLandmark& l : r.map) {
    map_x.push_back(l.position[0]);
    map_y.push_back(l.position[1]);
    append_curve(ellipses, ellipse_points(l.position, l.covariance, 2.0));
  }
  const bool motion_capture = has_heading_truth(r);
  panel.series.push_back(
      line_series(motion_capture ? "motion capture" : "GPS", ColourRole::truth, reference_x, reference_y));
  panel.series.push_back(line_series("EKF-SLAM", ColourRole::estimate, x, y));
  panel.series.push_back(polygon_series("2σ", ColourRole::bound, ellipses.x, ellipses.y));
  panel.series.push_back(point_series("surveyed", ColourRole::truth, survey_x, survey_y));
  panel.series.push_back(point_series("estimated", ColourRole::estimate, map_x, map_y));
  return panel;
}

/// Error of one coordinate of the pose against the reference, with 2σ of the filter.
Panel error_panel(const ReplayResult& r, Index i, const char* title) {
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

Panel nis_panel(const ReplayResult& r) {
  Panel panel{
      .title = "NIS of single sights", .x_label = "time (s)", .y_label = "NIS (2 dof)", .log_y = true};
  FigureData t, used, rejected_t, rejected;
  constexpr double kFloor = 1e-4;  // a logarithmic axis has no zero
  for (const ReplaySight& s : r.sights) {
    if (s.outcome == SightOutcome::updated) {
      t.push_back(s.time_s);
      used.push_back(std::max(kFloor, s.nis));
    } else if (s.outcome == SightOutcome::rejected) {
      rejected_t.push_back(s.time_s);
      rejected.push_back(std::max(kFloor, s.nis));
    }
  }
  panel.series.push_back(point_series("used", ColourRole::estimate, t, used));
  if (!rejected.empty())
    panel.series.push_back(point_series("rejected", ColourRole::alarm, rejected_t, rejected));
  panel.series.push_back(
      level_series("95 % of a consistent filter lie below", ColourRole::bound, gate_threshold(0.95)));
  return panel;
}

/// One curve for each landmark over the steps.
template <class Get>
Panel landmark_panel(const ReplayResult& r, const char* title, const char* y_label, Get get) {
  Panel panel{.title = title, .x_label = "time (s)", .y_label = y_label};
  std::map<int, std::pair<FigureData, FigureData>> curves;
  for (const ReplayStep& s : r.steps) {
    for (const ReplayLandmark& l : s.landmarks) {
      curves[l.landmark].first.push_back(s.time_s);
      curves[l.landmark].second.push_back(get(l));
    }
  }
  for (auto& [landmark, curve] : curves) {
    panel.series.push_back(line_series("", numbered_role(landmark), curve.first, curve.second));
  }
  return panel;
}

Panel trace_panel(const ReplayResult& r) {
  Panel panel{.title = "Covariance", .x_label = "time (s)", .y_label = "trace (m²)", .log_y = true};
  FigureData t, vehicle, landmarks;
  for (const ReplayStep& s : r.steps) {
    t.push_back(s.time_s);
    vehicle.push_back(s.covariance(0, 0) + s.covariance(1, 1));
    double sum = 0.0;
    for (const ReplayLandmark& l : s.landmarks) sum += l.covariance.trace();
    landmarks.push_back(sum > 0.0 ? sum : kNaN);
  }
  panel.series.push_back(line_series("vehicle position", ColourRole::first, t, vehicle));
  panel.series.push_back(line_series("all landmarks", ColourRole::second, t, landmarks));
  return panel;
}

std::string mean_text(const ReplayMean& mean) {
  return mean.count > 0 ? number_text(mean.mean()) : std::string("none");
}

}  // namespace

std::string replay_json(const ReplayResult& r) {
  Json settings;
  for (const ReplaySettingText& s : replay_settings_text(r.settings)) settings[s.key] = s.value;
  Json j;
  j["schema"] = 1;
  j["dataset"] = r.dataset;
  j["settings"] = std::move(settings);
  j["duration_s"] = json_number(r.duration_s);
  j["observations"] = r.observations;
  j["scans_with_observations"] = r.scans_with_observations;
  j["associated"] = r.associated;
  j["updated"] = r.updated;
  j["initialised"] = r.initialised;
  j["rejected"] = r.rejected;
  j["unassociated"] = r.unassociated;
  j["failed"] = r.failed;
  j["ambiguous"] = r.ambiguous;
  j["mismatched"] = r.mismatched;
  j["not_converged"] = r.not_converged;
  j["unused_rows"] = {{"of_robots", r.rows_of_robots},
                      {"of_unknown_barcodes", r.rows_of_unknown_barcodes},
                      {"before_start", r.rows_before_start}};
  j["nis"] = mean_json(r.nis);
  j["vehicle_rmse"] = json_number(r.vehicle_rmse);
  if (has_heading_truth(r)) j["heading_rmse_deg"] = json_number(r.heading_rmse_deg);
  j["landmark_rms"] = json_number(r.landmark_rms);
  j["landmark_rms_aligned"] = json_number(r.landmark_rms_aligned);
  j["covariance"] = {{"vehicle_max", json_number(r.covariance.vehicle_max)},
                     {"vehicle_final", json_number(r.covariance.vehicle_final)},
                     {"landmarks_max", json_number(r.covariance.landmarks_max)},
                     {"landmarks_final", json_number(r.covariance.landmarks_final)}};
  j[has_heading_truth(r) ? "pose_nees" : "gps_nees"] = mean_json(r.vehicle_nees);
  j["landmark_nees"] = mean_json(r.landmark_nees);
  j["null_reason"] = "null: no value contributes to this number";
  return j.dump(1);
}

ReportTable replay_table(const ReplayResult& r) {
  using enum ColumnAlign;
  ReportTable table{.title = fmt::format("{}, {} s", r.dataset, number_text(r.duration_s, 4)),
                    .columns = {{"", words}, {"value"}, {"expected"}, {"from", words}},
                    .rows = {},
                    .notes = {}};
  table.add({"sights", r.observations, "", fmt::format("{} times", r.scans_with_observations)});
  table.add({"associated", r.associated, "", "by the survey"});
  table.add({"rejected by the gate", r.rejected, "", ""});
  table.add({"mean NIS of a sight", mean_text(r.nis), number_text(r.nis.expected),
             fmt::format("{} sights", r.nis.count)});
  table.add({has_heading_truth(r) ? "mean NEES of the pose" : "mean NEES of the position",
             mean_text(r.vehicle_nees), number_text(r.vehicle_nees.expected),
             fmt::format("{} references", r.vehicle_nees.count)});
  table.add({"mean NEES of a landmark", mean_text(r.landmark_nees), number_text(r.landmark_nees.expected),
             fmt::format("{} landmarks", r.landmark_nees.count)});
  table.add({"vehicle RMSE (m)", r.vehicle_rmse, "",
             has_heading_truth(r) ? "against motion capture" : "against GPS"});
  if (has_heading_truth(r)) table.add({"heading RMSE (°)", r.heading_rmse_deg, "", "against motion capture"});
  table.add({"landmark RMS (m)", r.landmark_rms, "", "against the survey"});
  table.add(
      {"landmark RMS, aligned (m)", r.landmark_rms_aligned, "", "the survey moved rigidly onto the map"});
  table.add({"largest tr P of the position (m²)", r.covariance.vehicle_max, "", ""});
  table.add({"final tr P of the landmarks (m²)", r.covariance.landmarks_final, "",
             fmt::format("{} landmarks", r.map.size())});
  table.notes = {
      "One run of real data: errors along it are correlated, so these means have no χ² bounds of "
      "independent runs, and no verdict is given on NEES."};
  return table;
}

std::vector<Figure> replay_figures(const ReplayResult& r) {
  Figure map{
      .name = r.dataset + "-map",
      .caption =
          "Estimated path and map over the reference and the survey; ellipses are 2σ of the final map.",
      .panels = {map_panel(r)}};
  Figure vehicle{
      .name = r.dataset + "-vehicle",
      .caption =
          "Errors of the vehicle against the reference with the filter's 2σ, and the NIS of single "
          "sights.",
      .rows = 2,
      .cols = 2};
  vehicle.panels = {error_panel(r, 0, "Error in x"), error_panel(r, 1, "Error in y")};
  if (has_heading_truth(r)) vehicle.panels.push_back(error_panel(r, 2, "Error in heading"));
  vehicle.panels.push_back(nis_panel(r));
  if (!has_heading_truth(r)) vehicle.panels.push_back(trace_panel(r));

  Figure landmarks{.name = r.dataset + "-landmarks",
                   .caption =
                       "Each landmark from its first sight on: standard deviation, and how far a range "
                       "innovation moves it (norm of its rows of K).",
                   .rows = 1,
                   .cols = 2};
  landmarks.panels = {landmark_panel(r, "Landmark standard deviation", "√tr P (m)",
                                     [](const ReplayLandmark& l) { return std::sqrt(l.covariance.trace()); }),
                      landmark_panel(r, "Landmark gain", "gain of the range",
                                     [](const ReplayLandmark& l) { return l.gain.range; })};
  return {map, vehicle, landmarks};
}

std::vector<std::string> write_replay_report(const std::filesystem::path& directory, const ReplayResult& r) {
  make_directories(directory / "figures");
  const std::vector<Figure> figures = replay_figures(r);
  const std::vector<Drawing> drawings = draw_all(figures, directory / "figures");
  HtmlPage page(fmt::format("EKF-SLAM on {}", r.dataset), "Real data replayed by Credence");
  page.section("Results");
  page.table(replay_table(r));
  std::vector<std::string> problems;
  page.section("Figures");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    page.figure(figures[i], drawings[i], directory);
    if (!drawings[i].problem.empty()) problems.push_back(drawings[i].problem);
  }
  page.section("Settings");
  std::vector<std::pair<std::string, std::string>> facts;
  for (const ReplaySettingText& s : replay_settings_text(r.settings)) facts.emplace_back(s.key, s.value);
  page.facts(facts);
  page.write(directory / "index.html");
  return problems;
}

}  // namespace credence
