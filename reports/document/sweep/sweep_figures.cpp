#include "reports/document/sweep/sweep_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/append_item.h"
#include "core/nan.h"
#include "reports/document/sweep/swept_values.h"

namespace credence::internal {
namespace {

/// One of the two verdicts of a study.
using VerdictOf = ConsistencyVerdict StudyAnalysis::*;

bool is_numeric(const SweepAxis& axis) { return !std::isnan(swept_number(axis.values.front())); }

/// Whether values spread like powers: all positive, and the middle one nearer to the geometric than to the
/// arithmetic mean of the ends.
bool is_geometric(std::vector<double> values) {
  std::ranges::sort(values);
  if (values.size() < 3 || values.front() <= 0.0) return false;
  const double middle = values[values.size() / 2];
  return std::abs(middle - std::sqrt(values.front() * values.back())) <
         std::abs(middle - 0.5 * (values.front() + values.back()));
}

/// The curve of one setting of the other axes: mean over expected, and the factors on the claimed covariance
/// that a test at the verdict's confidence would not reject. They include 1 where the verdict is consistent.
struct RatioCurve {
  FigureData x, ratio, lower, upper;

  void add(double at, const ConsistencyVerdict& v) {
    x.push_back(at);
    ratio.push_back(v.mean / v.expected);
    lower.push_back(v.mean / v.bounds.upper);
    upper.push_back(v.mean / v.bounds.lower);
  }
};

/// Where the ratio of a consistent filter lies. Curves whose bounds differ have none in common: inside that
/// of one, the point of another may be a verdict.
struct ConsistencyBand {
  std::map<double, AxisRange> at;
  bool common = true;

  void add(double x, const ConsistencyVerdict& v) {
    constexpr double kRounding = 1e-9;
    const double low = v.bounds.lower / v.expected, high = v.bounds.upper / v.expected;
    if (!std::isfinite(low) || !std::isfinite(high)) return;
    const auto [place, is_new] = at.try_emplace(x, AxisRange{low, high});
    const AxisRange& first = place->second;
    common = common && std::abs(low - first.low) <= kRounding * high &&
             std::abs(high - first.high) <= kRounding * high;
  }
  Series series(double confidence) const {
    FigureData x, low, high;
    for (const auto& [where, range] : at) {
      x.push_back(where);
      low.push_back(range.low);
      high.push_back(range.high);
    }
    return band_series(fmt::format("consistent ({:g} %)", 100.0 * confidence), ColourRole::bound, x, low,
                       high);
  }
};

/// The numeric axis with most values, at least two; size() if there is none.
std::size_t longest_axis(const SweepPlan& plan) {
  std::size_t axis = plan.axes.size(), longest = 1;
  for (std::size_t a = 0; a < plan.axes.size(); ++a) {
    if (plan.axes[a].values.size() <= longest || !is_numeric(plan.axes[a])) continue;
    axis = a;
    longest = plan.axes[a].values.size();
  }
  return axis;
}

/// What tells an axis from the others in few words: the last of its key, or the whole key where another ends
/// alike.
std::string short_name(const SweepPlan& plan, std::size_t axis) {
  const auto last_word = [](const SweepAxis& a) { return a.path.substr(a.path.rfind('.') + 1); };
  std::string word = last_word(plan.axes[axis]);
  return std::ranges::count(plan.axes, word, last_word) == 1 ? word : plan.axes[axis].path;
}

/// The other axes and their values, which a curve is named after: "inflation = map".
std::string label_of(const SweepPlan& plan, const SweepPoint& point, std::size_t axis) {
  std::string label;
  for (std::size_t i = 0; i < point.values.size(); ++i) {
    if (i != axis)
      append_item(label, fmt::format("{} = {}", short_name(plan, i), swept_text(point.values[i])));
  }
  return label;
}

/// Room for the bars at both ends; none of a single value.
std::optional<AxisRange> with_room(double low, double high, bool log) {
  constexpr double kRoom = 0.04;
  if (!(high > low)) return std::nullopt;
  const double factor = std::pow(high / low, kRoom), more = kRoom * (high - low);
  return log ? AxisRange{low / factor, high * factor} : AxisRange{low - more, high + more};
}

Panel curve_panel(const SweepAnalysis& sweep, std::size_t axis, const char* what, VerdictOf verdict) {
  std::vector<std::pair<std::string, RatioCurve>> curves;  // in the order of the sweep
  const auto curve_of = [&](const std::string& label) -> RatioCurve& {
    const auto found = std::ranges::find(curves, label, &std::pair<std::string, RatioCurve>::first);
    return found != curves.end() ? found->second : curves.emplace_back(label, RatioCurve{}).second;
  };
  ConsistencyBand band;
  const auto value_of = [&](std::size_t n) { return swept_number(sweep.point(n).values[axis]); };
  std::vector<std::size_t> order(sweep.studies.size());  // a line goes from left to right
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, value_of);
  std::vector<double> values;
  for (const std::size_t n : order) {
    const SweepPoint& point = sweep.point(n);
    const double x = value_of(n);
    values.push_back(x);
    curve_of(label_of(sweep.plan, point, axis)).add(x, sweep.studies[n].*verdict);
    band.add(x, sweep.studies[n].*verdict);
  }
  Panel panel{.title = what,
              .x_label = sweep.plan.axes[axis].path,
              .y_label = fmt::format("mean {} / expected", what),
              .log_x = is_geometric(values),
              .log_y = true};
  if (band.common) panel.series.push_back(band.series(sweep.confidence()));
  panel.series.push_back(level_series("expected", ColourRole::neutral, 1.0));
  panel.x_range = with_room(values.front(), values.back(), panel.log_x);
  constexpr double kApart = 4.0;  // bars at one x beside each other
  Index i = 0;
  for (const auto& [label, c] : curves) {
    const double aside =
        kApart * (static_cast<double>(i) - 0.5 * static_cast<double>(std::ssize(curves) - 1));
    const ColourRole role = numbered_role(i++);
    panel.series.push_back(line_series("", role, c.x, c.ratio));
    panel.series.back().aside = aside;
    panel.series.push_back(
        error_bar_series(label.empty() ? "measured" : label, role, c.x, c.ratio, c.lower, c.upper));
    panel.series.back().aside = aside;
  }
  return panel;
}

std::vector<Figure> curve_figures(const SweepAnalysis& sweep, std::size_t axis) {
  return {{.name = "sweep",
           .caption = fmt::format(
               "Mean NEES and NIS over their expected values, logarithmic: 1 is consistent, above "
               "is optimistic, below pessimistic. Bars: factors on the claimed covariance that "
               "agree with what was measured, each at {:g} %; a bar without 1 is a verdict.",
               100.0 * sweep.confidence()),
           .rows = 1,
           .cols = 2,
           .panels = {curve_panel(sweep, axis, "NEES", &StudyAnalysis::nees),
                      curve_panel(sweep, axis, "NIS", &StudyAnalysis::nis)}}};
}

/// One side of a heat map: places of its values, and their names where these are no numbers.
struct Side {
  FigureData centres;
  std::vector<FigureText> names;
  bool log = false;
};

Side side_of(const SweepAxis& axis) {
  Side side;
  if (is_numeric(axis)) {
    for (const ScalarValue& value : axis.values) side.centres.push_back(swept_number(value));
    std::ranges::sort(side.centres);
    side.log = is_geometric(side.centres);
    if (std::ranges::adjacent_find(side.centres, std::greater_equal<>()) == side.centres.end()) return side;
  }
  side = {.centres = index_axis(static_cast<Index>(axis.values.size())), .names = {}, .log = false};
  for (const ScalarValue& value : axis.values) side.names.emplace_back(swept_text(value));
  return side;
}

Index place_of(const SweepAxis& axis, const Side& side, const ScalarValue& value) {
  if (side.names.empty()) {
    return std::ranges::find(side.centres, swept_number(value)) - side.centres.begin();
  }
  return std::ranges::find_if(axis.values,
                              [&](const ScalarValue& v) { return swept_text(v) == swept_text(value); }) -
         axis.values.begin();
}

Panel heat_panel(const SweepAnalysis& sweep, std::size_t across, std::size_t up, const char* what,
                 VerdictOf verdict) {
  const SweepAxis &x_axis = sweep.plan.axes[across], &y_axis = sweep.plan.axes[up];
  const Side x = side_of(x_axis), y = side_of(y_axis);
  Matrix ratio = Matrix::Constant(std::ssize(y.centres), std::ssize(x.centres), kNaN);
  FigureData agree_x, agree_y;
  double spread = std::log(1.1);
  for (std::size_t n = 0; n < sweep.studies.size(); ++n) {
    const ConsistencyVerdict& v = sweep.studies[n].*verdict;
    const Index column = place_of(x_axis, x, sweep.point(n).values[across]);
    const Index row = place_of(y_axis, y, sweep.point(n).values[up]);
    ratio(row, column) = v.mean / v.expected;
    if (std::isfinite(ratio(row, column)) && ratio(row, column) > 0.0) {
      spread = std::max(spread, std::abs(std::log(ratio(row, column))));
    }
    if (v.verdict != Verdict::consistent) continue;
    agree_x.push_back(x.centres[static_cast<std::size_t>(column)]);
    agree_y.push_back(y.centres[static_cast<std::size_t>(row)]);
  }
  Panel panel{.title = what,
              .x_label = x_axis.path,
              .y_label = y_axis.path,
              .log_x = x.log,
              .log_y = y.log,
              .x_names = x.names,
              .y_names = y.names,
              .colour_label = fmt::format("mean {} / expected", what),
              .colour_range = AxisRange{std::exp(-spread), std::exp(spread)},
              .log_colour = true,
              .colour_scale = ColourScale::diverging};  // white, its middle, is consistent
  panel.series = {heat_series(x.centres, y.centres, std::move(ratio))};
  if (!agree_x.empty()) {
    panel.series.push_back(
        point_series("consistent", ColourRole::truth, std::move(agree_x), std::move(agree_y)));
    panel.series.back().marker = MarkerShape::dot;
  }
  return panel;
}

std::vector<Figure> heat_figures(const SweepAnalysis& sweep) {
  const SweepPlan& plan = sweep.plan;
  const std::size_t across = plan.axes[0].values.size() >= plan.axes[1].values.size() ? 0 : 1;
  const std::size_t up = 1 - across;
  return {{.name = "sweep",
           .caption =
               "Mean NEES and NIS over their expected values: white is consistent, red optimistic, blue "
               "pessimistic; grey: no result. A dot marks a configuration that its own test does not reject.",
           .rows = 1,
           .cols = 2,
           .panels = {heat_panel(sweep, across, up, "NEES", &StudyAnalysis::nees),
                      heat_panel(sweep, across, up, "NIS", &StudyAnalysis::nis)}}};
}

}  // namespace

std::vector<Figure> sweep_figures(const SweepAnalysis& sweep) {
  constexpr std::size_t kMostCurves = 6, kGrid = 3;
  const SweepPlan& plan = sweep.plan;
  if (sweep.studies.empty()) return {};
  const std::size_t axis = longest_axis(plan);
  const bool plane = plan.axes.size() == 2 && plan.mode == SweepMode::grid;
  const bool both_numeric = plane && is_numeric(plan.axes[0]) && is_numeric(plan.axes[1]);
  const bool wide = plane && std::min(plan.axes[0].values.size(), plan.axes[1].values.size()) >= kGrid;
  if (wide && (both_numeric || axis == plan.axes.size())) return heat_figures(sweep);
  if (axis == plan.axes.size()) return {};
  std::map<std::string, int> curves;
  for (std::size_t n = 0; n < sweep.studies.size(); ++n) ++curves[label_of(plan, sweep.point(n), axis)];
  if (curves.size() <= kMostCurves) return curve_figures(sweep, axis);
  return plane ? heat_figures(sweep) : std::vector<Figure>{};
}

}  // namespace credence::internal
