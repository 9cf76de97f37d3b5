#include "reports/figures/study_figures.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "core/manifold/angle.h"
#include "core/nan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/shown_unit.h"
#include "reports/document/study/judgement_report.h"
#include "reports/figures/figure_axis.h"
#include "reports/figures/step_axis.h"

namespace credence::internal {
namespace {

double at(const Vector& v, Index i) { return i < v.size() ? v[i] : kNaN; }
double sigma_at(const TraceStep& step, Index i) { return i < step.P.rows() ? std::sqrt(step.P(i, i)) : kNaN; }

FigureText state_name(const RunTrace& trace, Index i) {
  const Index vehicle = std::ssize(trace.layout.blocks.front().states);
  return i < vehicle ? FigureText("vehicle r")
                     : figure_markup(fmt::format("landmark f_{{{}}}", i - vehicle + 1));
}

void add_error(Panel& panel, const FigureData& x, const RunTrace& trace, Index i, const FigureText& label,
               ColourRole role, bool label_bounds, double scale = 1.0) {
  const auto error = [&](const TraceStep& s) { return scale * at(s.error, i); };
  const auto two_sigma = [&](const TraceStep& s) { return 2.0 * scale * sigma_at(s, i); };
  std::ranges::move(error_series(label, role, x, figure_data(trace.steps, error),
                                 figure_data(trace.steps, two_sigma), label_bounds),
                    std::back_inserter(panel.series));
}

Series sigma_band(const RunTrace& trace, const FigureData& steps, Index i, FigureText label) {
  const auto bound = [&](double sigmas) {
    return figure_data(trace.steps,
                       [&](const TraceStep& s) { return at(s.estimate, i) + sigmas * sigma_at(s, i); });
  };
  return band_series(std::move(label), numbered_role(i), steps, bound(-2.0), bound(2.0));
}

Series true_position(const RunTrace& trace, const FigureData& steps, Index i, FigureText label) {
  return line_series(std::move(label), ColourRole::truth, steps,
                     figure_data(trace.steps, [&](const TraceStep& s) { return at(s.truth, i); }));
}

Series estimated_position(const RunTrace& trace, const FigureData& steps, Index i, FigureText label) {
  return line_series(std::move(label), numbered_role(i), steps,
                     figure_data(trace.steps, [&](const TraceStep& s) { return at(s.estimate, i); }));
}

Panel vehicle_position_panel(const RunTrace& trace, const FigureData& steps) {
  Panel panel{.title = "Vehicle position", .x_label = "step", .y_label = "position (m)"};
  panel.series = {sigma_band(trace, steps, 0, "±2σ"), true_position(trace, steps, 0, "true"),
                  estimated_position(trace, steps, 0, "estimated")};
  return panel;
}

/// Landmarks as estimated, and as measured from where the vehicle believes to be. The true ones are named
/// where their lines start.
Panel landmark_positions_panel(const RunTrace& trace, const FigureData& steps) {
  Panel panel{.title = "Landmark positions", .x_label = "step", .y_label = "position (m)"};
  const Index n = trace.steps.front().truth.size();
  const auto once = [](Index i, const char* label) { return FigureText(i == 1 ? label : ""); };
  for (Index i = 1; i < n; ++i) panel.series.push_back(sigma_band(trace, steps, i, once(i, "±2σ")));
  for (Index i = 1; i < n; ++i) {
    const Index own = trace.anchor_positions.cols() + i - 1;
    panel.series.push_back(point_series(
        once(i, "measured"), ColourRole::measurement, steps,
        figure_data(trace.steps, [&](const TraceStep& s) { return at(s.estimate, 0) + at(s.z, own); })));
  }
  for (Index i = 1; i < n; ++i) panel.series.push_back(true_position(trace, steps, i, once(i, "true")));
  FigureData y;
  std::vector<FigureText> names;
  for (Index i = 1; i < n; ++i) {
    panel.series.push_back(estimated_position(trace, steps, i, state_name(trace, i)));
    y.push_back(at(trace.steps.front().truth, i));
    names.push_back(figure_markup(fmt::format("f_{{{}}}", i)));
  }
  panel.series.push_back(text_series(ColourRole::truth, FigureData(y.size(), steps.front()), y, names));
  return panel;
}

Panel gains_panel(const RunTrace& trace, const FigureData& steps) {
  Panel panel{.title = "Kalman gains", .x_label = "step", .y_label = "gain (m/m)"};
  const Index n = trace.steps.front().truth.size();
  const Index anchors = trace.anchor_positions.cols();
  constexpr Index kFew = 4;
  for (Index i = 0; i < n; ++i) {
    // Each state by the measurement of its own landmark, the vehicle by the first measurement.
    const Index column = i == 0 ? 0 : anchors + i - 1;
    panel.series.push_back(
        line_series(i == 0 ? figure_markup("K_{r}") : figure_markup(fmt::format("K_{{f{}}}", i)),
                    numbered_role(i), steps, figure_data(trace.steps, [&](const TraceStep& s) {
                      return i < s.K.rows() && column < s.K.cols() ? s.K(i, column) : kNaN;
                    })));
    // Equal gains lie on each other; the lower ones are seen at the sides.
    if (i > 0 && n <= kFew) panel.series.back().weight = 1.0 + static_cast<double>(n - 1 - i);
  }
  return panel;
}

/// Error curves with 2σ of several states, each in a panel's own colours.
Panel errors_panel(FigureText title, const RunTrace& trace, const FigureData& steps, Index first,
                   Index last) {
  Panel panel{.title = std::move(title), .x_label = "step", .y_label = "error (m)"};
  for (Index i = first; i < last; ++i) {
    add_error(panel, steps, trace, i, last - first > 1 ? state_name(trace, i) : FigureText("error"),
              numbered_role(i), i == first);
  }
  return panel;
}

/// A whole number 1, 2, 5, … by which ellipses are drawn larger, so that the 2σ of half of the poses is 3 %
/// of the path's extent at least.
int ellipse_scale(const RunTrace& trace) {
  constexpr double kLeastShare = 0.03;
  constexpr int kMost = 1000;
  std::vector<double> axes;
  Eigen::AlignedBox2d extent;
  for (const TraceStep& s : trace.steps) {
    extent.extend(s.truth.head<2>().eval());
    const Eigen::Matrix2d P = s.P.topLeftCorner<2, 2>();
    const double mean = 0.5 * P.trace(), half = std::hypot(0.5 * (P(0, 0) - P(1, 1)), P(0, 1));
    if (mean + half > 0.0) axes.push_back(2.0 * std::sqrt(mean + half));
  }
  if (axes.empty()) return 1;
  const auto median = axes.begin() + std::ssize(axes) / 2;
  std::ranges::nth_element(axes, median);
  const double wanted = kLeastShare * extent.sizes().maxCoeff();
  int scale = 1;
  for (int i = 0; scale * *median < wanted && scale < kMost; ++i) {
    scale = i % 3 == 1 ? scale / 2 * 5 : 2 * scale;
  }
  return scale;
}

Panel map_panel(const RunTrace& trace, int scale) {
  Panel panel{.title = "Map", .x_label = "x (m)", .y_label = "y (m)", .equal_aspect = true};
  const TraceStep& last = trace.steps.back();
  PlanarCurve pose_ellipses, landmark_ellipses;
  const std::size_t every = std::max<std::size_t>(1, trace.steps.size() / 12);
  for (std::size_t k = 0; k < trace.steps.size(); k += every) {
    const TraceStep& s = trace.steps[k];
    append_curve(pose_ellipses, ellipse_points(s.estimate.head<2>(), s.P.topLeftCorner<2, 2>(), 2.0 * scale));
  }
  FigureData landmark_x, landmark_y;
  for (Index j = 3; j + 1 < last.estimate.size(); j += 2) {
    append_curve(landmark_ellipses,
                 ellipse_points(last.estimate.segment<2>(j), last.P.block<2, 2>(j, j), 2.0 * scale));
    landmark_x.push_back(last.estimate[j]);
    landmark_y.push_back(last.estimate[j + 1]);
  }
  const std::string times = scale == 1 ? "" : fmt::format(", {}×", scale);
  panel.series.push_back(
      polygon_series("vehicle 2σ" + times, ColourRole::bound, pose_ellipses.x, pose_ellipses.y));
  panel.series.push_back(
      polygon_series("landmark 2σ" + times, ColourRole::estimate, landmark_ellipses.x, landmark_ellipses.y));
  panel.series.push_back(line_series(
      "true path", ColourRole::truth, figure_data(trace.steps, [](const TraceStep& s) { return s.truth[0]; }),
      figure_data(trace.steps, [](const TraceStep& s) { return s.truth[1]; })));
  panel.series.push_back(
      line_series("estimated path", ColourRole::estimate,
                  figure_data(trace.steps, [](const TraceStep& s) { return s.estimate[0]; }),
                  figure_data(trace.steps, [](const TraceStep& s) { return s.estimate[1]; })));
  panel.series.push_back(point_series("landmarks, true", ColourRole::truth,
                                      FigureData(trace.landmark_positions.row(0)),
                                      FigureData(trace.landmark_positions.row(1))));
  panel.series.push_back(point_series("estimated", ColourRole::estimate, landmark_x, landmark_y));
  if (trace.anchor_positions.cols() > 0) {
    Series anchors = point_series("anchors", ColourRole::exact, FigureData(trace.anchor_positions.row(0)),
                                  FigureData(trace.anchor_positions.row(1)));
    anchors.marker = MarkerShape::square;
    panel.series.push_back(anchors);
  }
  return panel;
}

}  // namespace

std::string over_runs_text(std::int64_t runs) {
  return runs == 1 ? "of one run" : fmt::format("means over {} runs", runs);
}

namespace {

/// A mean far above its bounds would leave nothing else to be seen on a linear axis, and means far below them
/// are a line on zero.
void show_divergence(Panel& panel, std::span<const StepTest> steps) {
  constexpr double kFarAbove = 50.0, kFarBelow = 10.0, kLowest = 1e-3;
  double highest = 0.0, bound = 0.0, sum = 0.0, expected = 0.0, count = 0.0;
  double least = std::numeric_limits<double>::infinity(), lowest = least;
  for (const StepTest& step : steps) {
    if (!step.has_data()) continue;
    if (std::isfinite(step.mean)) highest = std::max(highest, step.mean);
    if (std::isfinite(step.simultaneous_upper)) bound = std::max(bound, step.simultaneous_upper);
    if (step.expected > 0.0) least = std::min(least, step.expected);
    if (step.mean > 0.0) lowest = std::min(lowest, step.mean);
    sum += step.mean;
    expected += step.expected;
    count += 1.0;
  }
  if (!(bound > 0.0 && std::isfinite(least))) return;
  const bool below = sum > 0.0 && kFarBelow * sum < expected;
  if (!below && !(highest > kFarAbove * bound)) return;
  panel.log_y = true;
  const double low = below ? std::max(0.5 * lowest, kLowest * sum / count)
                           : std::max(std::min(0.5 * lowest, 0.1 * least), kLowest * least);
  panel.y_range = {low, 2.0 * std::max(highest, bound)};
}

/// Whether the dof goes up and down, so that lines would fill the panel; that of a map only grows.
bool falls_often(std::span<const StepTest> steps) {
  constexpr double kMuch = 0.05;
  constexpr std::size_t kOften = 20;  // of so many steps, one
  std::size_t falls = 0, count = 0;
  double before = 0.0;
  for (const StepTest& step : steps) {
    if (!step.has_data()) continue;
    falls += step.expected < (1.0 - kMuch) * before ? 1 : 0;
    before = step.expected;
    ++count;
  }
  return kOften * falls > count;
}

void divide_by_dof(StepTest& step) {
  const double dof = step.expected;
  for (double* number : {&step.mean, &step.expected, &step.lower, &step.upper, &step.simultaneous_lower,
                         &step.simultaneous_upper}) {
    *number /= dof;
  }
}

}  // namespace

Panel verdict_panel(const std::string& title, const char* y_label, const ConsistencyVerdict& verdict,
                    const FigureData& exact) {
  const StepTimes* const times = verdict.times.get();
  Panel panel{.title = title, .x_label = step_label(times), .y_label = y_label};
  const bool sparse =
      2 * std::ranges::count_if(verdict.steps, &StepTest::has_data) <= std::ssize(verdict.steps);
  FigureData x;
  std::vector<StepTest> shown;
  for (std::size_t k = 0; k < verdict.steps.size(); ++k) {
    if (sparse && !verdict.steps[k].has_data()) continue;
    x.push_back(step_place(times, verdict.step_of(static_cast<std::int64_t>(k) + 1)));
    shown.push_back(verdict.steps[k]);
  }
  const bool over_dof = falls_often(shown);
  if (over_dof) {
    panel.y_label = std::string(y_label) + " over dof";
    std::ranges::for_each(shown, divide_by_dof);
  }
  const auto tested = [&](double StepTest::*number) {
    return figure_data(shown, [&](const StepTest& step) { return step.has_data() ? step.*number : kNaN; });
  };
  panel.series = {
      band_series(fmt::format("{:g} % of single steps", 100.0 * verdict.confidence), ColourRole::bound, x,
                  tested(&StepTest::lower), tested(&StepTest::upper)),
      line_series("all steps together", ColourRole::bound, x, tested(&StepTest::simultaneous_lower)),
      line_series("", ColourRole::bound, x, tested(&StepTest::simultaneous_upper)),
      line_series("expected", ColourRole::neutral, x, tested(&StepTest::expected)),
      line_series("measured mean", ColourRole::estimate, x, tested(&StepTest::mean))};
  if (!exact.empty() && !over_dof)
    panel.series.push_back(line_series("exact", ColourRole::exact, step_places(times, exact.size()), exact));
  show_divergence(panel, shown);
  return panel;
}

namespace {

/// The inconsistent ones, the worst of them first, then the others as they stand.
void sort_worst_first(std::vector<TitledVerdict>& verdicts) {
  const auto badness = [](const TitledVerdict& titled) {
    const ConsistencyVerdict& v = *titled.verdict;
    // p-values of many runs may all be 0.
    const double deviation = std::abs(v.mean / v.expected - 1.0) * std::sqrt(0.5 * v.dof);
    return is_inconsistent(v.verdict) ? std::pair(v.p_value, -deviation) : std::pair(2.0, 0.0);
  };
  std::ranges::stable_sort(verdicts, {}, badness);
}

}  // namespace

void tell_cut_means(Figure& figure) {
  const bool cut = std::ranges::any_of(figure.panels, [](const Panel& panel) {
    return panel.log_y && panel.y_range && std::ranges::any_of(panel.series, [&](const Series& series) {
             return series.role == ColourRole::estimate &&
                    std::ranges::any_of(series.y, [&](double y) { return y < panel.y_range->low; });
           });
  });
  if (cut) figure.caption += " Means below a logarithmic axis are cut off.";
}

std::vector<Panel> verdict_panels(std::vector<TitledVerdict> verdicts, const char* y_label, const char* what,
                                  std::string& caption) {
  std::erase_if(verdicts, [](const TitledVerdict& v) { return v.verdict->count == 0; });
  if (const std::size_t all = verdicts.size(); all > kBlockPanels) {
    sort_worst_first(verdicts);
    verdicts.resize(kBlockPanels);
    caption += fmt::format(" Of {} {} {} are shown, inconsistent ones first.", all, what, kBlockPanels);
  }
  std::vector<Panel> panels;
  panels.reserve(verdicts.size());
  for (const TitledVerdict& v : verdicts) panels.push_back(verdict_panel(v.title, y_label, *v.verdict, {}));
  return panels;
}

std::vector<Panel> nis_panels(const Judgement& judgement, std::string& caption) {
  if (judgement.sensors.size() < 2) return {verdict_panel("NIS", "mean NIS", judgement.nis, {})};
  std::vector<TitledVerdict> verdicts;
  verdicts.reserve(judgement.sensors.size());
  for (const SensorJudgement& sensor : judgement.sensors)
    verdicts.push_back({"NIS of " + sensor.name, &sensor.nis});
  return verdict_panels(std::move(verdicts), "mean NIS", "sensors", caption);
}

Figure monobot_run_figure(const std::string& name, const RunTrace& trace) {
  const FigureData steps = index_axis(static_cast<Index>(trace.steps.size()), 0);
  const Index n = trace.steps.front().truth.size();
  Figure figure{
      .name = name + "-run",
      .caption = fmt::format("Run {}, as in the paper's columns: positions with 2σ bounds and noisy "
                             "measurements, errors, and the gains of each state for the measurement of its "
                             "landmark, of the vehicle for the first measurement.",
                             trace.run),
      .rows = 2,
      .cols = 3};
  figure.panels.push_back(vehicle_position_panel(trace, steps));
  figure.panels.push_back(landmark_positions_panel(trace, steps));
  figure.panels.push_back(gains_panel(trace, steps));
  figure.panels.push_back(errors_panel("Vehicle error", trace, steps, 0, 1));
  figure.panels.push_back(errors_panel("Landmark errors", trace, steps, 1, n));
  return figure;
}

Figure planar_run_figure(const std::string& name, const RunTrace& trace, const StepTimes* times) {
  const FigureData time = step_places(times, trace.steps.size(), 0);
  const int scale = ellipse_scale(trace);
  Figure figure{
      .name = name + "-run",
      .caption = fmt::format("Run {}: paths, landmarks and 2σ ellipses{}; errors of the pose with 2σ.",
                             trace.run, scale == 1 ? "" : fmt::format(", drawn {} times as large", scale)),
      .rows = 2,
      .cols = 2};
  figure.panels.push_back(map_panel(trace, scale));
  const char* titles[] = {"Error in x", "Error in y", "Error in heading"};
  for (Index i = 0; i < 3; ++i) {
    Panel panel{
        .title = titles[i], .x_label = step_label(times), .y_label = i < 2 ? "error (m)" : "error (°)"};
    add_error(panel, time, trace, i, "error", ColourRole::estimate, true,
              i < 2 ? 1.0 : 1.0 / kRadiansPerDegree);
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

namespace {

/// The states of a layout in the order in which they are shown, at most kStatePanels of the first n.
std::vector<std::size_t> shown_states(const RunLayout& layout, std::size_t n,
                                      std::span<const BlockVerdict> blocks) {
  std::vector<std::size_t> shown;
  const auto show = [&](std::size_t state) {
    if (state < n && shown.size() < kStatePanels && std::ranges::find(shown, state) == shown.end())
      shown.push_back(state);
  };
  if (n > kStatePanels) {
    std::vector<TitledVerdict> verdicts;
    for (const BlockVerdict& block : blocks) {
      if (is_inconsistent(block.verdict.verdict)) verdicts.push_back({block.name, &block.verdict});
    }
    sort_worst_first(verdicts);
    for (const TitledVerdict& block : verdicts) {
      const auto states = std::ranges::find(layout.blocks, block.title, &Block::name);
      // Of a map every landmark has a block of its own.
      if (states == layout.blocks.end() || states->part == Part::map) continue;
      for (const Index state : states->states) show(static_cast<std::size_t>(state));
    }
  }
  for (std::size_t state = 0; state < n; ++state) show(state);
  return shown;
}

}  // namespace

ErrorUnit error_unit(std::string_view unit) {
  const ShownUnit shown = shown_unit(unit);
  return {"error" + unit_in_brackets(shown.name), shown.scale};
}

Figure states_run_figure(const std::string& name, const RunTrace& trace, std::span<const BlockVerdict> blocks,
                         const StepTimes* times) {
  const FigureData steps = step_places(times, trace.steps.size(), 0);
  const auto n = static_cast<std::size_t>(trace.steps.front().truth.size());
  const std::vector<std::size_t> states = shown_states(trace.layout, n, blocks);
  const bool by_block = n > states.size() && states.back() != states.size() - 1;
  const std::string which =
      n == states.size() ? ""
      : by_block ? fmt::format(" of {} of {} states, those of inconsistent blocks first,", states.size(), n)
                 : fmt::format(" of the first {} of {} states", states.size(), n);
  Figure figure{.name = name + "-run", .caption = fmt::format("Run {}: errors{} with 2σ.", trace.run, which)};
  for (const std::size_t i : states) {
    const ErrorUnit unit = error_unit(unit_of_states(trace.layout, {static_cast<Index>(i)}));
    Panel panel{.title = trace.layout.states[i], .x_label = step_label(times), .y_label = unit.label};
    add_error(panel, steps, trace, static_cast<Index>(i), "error", ColourRole::estimate, true, unit.scale);
    figure.panels.push_back(std::move(panel));
  }
  leave_out_start(figure, false);
  arrange(figure);
  return figure;
}

Figure consistency_figure(const std::string& name, const StudyAnalysis& analysis) {
  Figure figure{.name = name + "-consistency",
                .caption = fmt::format(
                    "NEES and NIS, {}, and the trace of P. A consistent filter stays within the band "
                    "at {:g} % of single steps, and between the outer lines at all steps.",
                    over_runs_text(analysis.statistics.runs), 100.0 * analysis.nees.confidence)};
  figure.panels.push_back(
      verdict_panel("NEES", "mean NEES", analysis.nees, figure_data(analysis.exact, &ExactMoments::nees)));
  if (analysis.judgement && analysis.judgement->sensors.size() > 1) {
    std::ranges::move(nis_panels(*analysis.judgement, figure.caption), std::back_inserter(figure.panels));
  } else {
    figure.panels.push_back(
        verdict_panel("NIS", "mean NIS", analysis.nis, figure_data(analysis.exact, &ExactMoments::nis)));
  }
  const CovarianceCurves& c = analysis.covariance;
  const RunFigure kind = world_of(analysis.scenario).figure;
  const StepTimes* const times = analysis.nees.times.get();
  Panel panel{.title = "Covariance",
              .x_label = step_label(times),
              .y_label = kind == RunFigure::states && c.vehicle.empty() ? "trace" : "trace (m²)"};
  const FigureData x = step_places(times, c.trace.size());
  if (kind == RunFigure::states) {
    // Beside a position all states together have no unit.
    panel.series.push_back(c.vehicle.empty() ? line_series("all states", ColourRole::first, x, c.trace)
                                             : line_series("position", ColourRole::first, x, c.vehicle));
  } else {
    panel.series.push_back(line_series(kind == RunFigure::plane_slam ? "vehicle position" : "vehicle",
                                       ColourRole::first, x, c.vehicle));
    panel.series.push_back(line_series("landmarks", ColourRole::second, x, c.landmarks));
  }
  figure.panels.push_back(std::move(panel));
  leave_out_start(figure, true);
  tell_cut_means(figure);
  arrange(figure);
  return figure;
}

namespace {

/// RMSE, what P claims and the bound of one block, by step.
Panel accuracy_panel(const std::string& title, const char* y_label, const StepTimes* times,
                     const std::vector<double>& rmse, const std::vector<double>& claimed,
                     const BoundCurve& curve, double scale) {
  Panel panel{.title = title, .x_label = step_label(times), .y_label = y_label};
  const auto roots = [scale](const std::vector<double>& squares) {
    return figure_data(squares, [scale](double value) { return scale * std::sqrt(value); });
  };
  const FigureData x = step_places(times, rmse.size());
  panel.series.push_back(line_series("RMSE", ColourRole::estimate, x,
                                     figure_data(rmse, [scale](double value) { return scale * value; })));
  panel.series.push_back(line_series("bound", ColourRole::exact, x, roots(curve.bound)));
  panel.series.push_back(line_series("at the truth", ColourRole::neutral, x, roots(curve.at_truth)));
  if (!claimed.empty()) panel.series.push_back(line_series("P claims", ColourRole::bound, x, roots(claimed)));
  return panel;
}

/// Without panels where there is no bound.
Figure accuracy_figure(const std::string& name, const StudyAnalysis& a) {
  Figure figure{
      .name = name + "-accuracy",
      .caption =
          "Root mean squared errors over the runs, what P claims of them, what a filter would claim with its "
          "Jacobians at the truth, and the posterior Cramér-Rao bound."};
  if (!a.bound) return figure;
  const StepTimes* const times = a.nees.times.get();
  const auto add = [&figure](Panel panel) {
    const bool shown = has_data(panel);
    if (shown) figure.panels.push_back(std::move(panel));
    return shown;
  };
  for (const BoundCurve& curve : a.bound->blocks) {
    if (curve.block == "position" && !a.errors.position_m.empty()) {
      add(accuracy_panel("Position", "error (m)", times, a.errors.position_m, a.covariance.vehicle, curve,
                         1.0));
    } else if ((curve.block == "heading" || curve.block == "attitude") && !a.errors.heading_rad.empty()) {
      add(accuracy_panel(curve.block == "heading" ? "Heading" : "Attitude", "error (°)", times,
                         a.errors.heading_rad, a.covariance.heading, curve, 1.0 / kRadiansPerDegree));
    } else if (curve.block == "all landmarks" && !a.errors.landmark_m.empty()) {
      const bool shown = add(accuracy_panel("Landmarks", "error (m)", times, a.errors.landmark_m,
                                            a.covariance.landmark, curve, 1.0));
      if (!shown) continue;
      figure.caption +=
          " Errors and claims of landmarks are of those that a run has in its state; the bound begins where "
          "every run has all.";
    }
  }
  figure.cols = std::max(1, static_cast<int>(figure.panels.size()));
  return figure;
}

}  // namespace

std::vector<Figure> study_figures(const std::string& name, const StudyAnalysis& analysis,
                                  const std::optional<RunTrace>& trace) {
  std::vector<Figure> figures = {consistency_figure(name, analysis)};
  const RunFigure run = world_of(analysis.scenario).figure;
  if (trace) {
    const StepTimes* const times = analysis.nees.times.get();
    const auto blocks = analysis.judgement ? std::span<const BlockVerdict>(analysis.judgement->blocks)
                                           : std::span<const BlockVerdict>();
    figures.push_back(run == RunFigure::line_slam    ? monobot_run_figure(name, *trace)
                      : run == RunFigure::plane_slam ? planar_run_figure(name, *trace, times)
                                                     : states_run_figure(name, *trace, blocks, times));
  }
  figures.push_back(accuracy_figure(name, analysis));
  return figures;
}

}  // namespace credence::internal
