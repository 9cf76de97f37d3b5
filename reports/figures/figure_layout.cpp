#include "reports/figures/figure_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reports/figures/figure_axis.h"
#include "reports/figures/figure_text.h"
#include "reports/figures/panel_scale.h"

namespace credence::internal {
namespace {

constexpr double kLine = 17.0;        // distance of lines of text
constexpr double kGap = 6.0;          // between things that do not belong together
constexpr double kSample = 22.0;      // length of a legend's sample
constexpr double kTickLabels = 20.0;  // from the axes to below their tick labels
constexpr double kColourBarGap = 10.0;

int wanted_x_ticks(double width) { return std::max(2, static_cast<int>(width / 38.0)); }
int wanted_y_ticks(double height) { return std::max(2, static_cast<int>(height / 26.0)); }

// As many ticks as fit with their labels side by side.
Axis make_x_axis(AxisRange range, bool log, double width, bool whole) {
  for (int wanted = wanted_x_ticks(width);; --wanted) {
    Axis axis = make_axis(range, log, wanted, whole);
    const double room = width / static_cast<double>(std::max<std::size_t>(axis.ticks.size(), 1));
    if (wanted <= 1 || widest_label(axis) + 2.0 * kGap <= room) return axis;
  }
}

// Names instead of numbers at 1, 2, …; of many that do not fit beside each other every other, third, ….
void name_ticks(const std::vector<FigureText>& names, double room, double needed_for_one, Axis& axis) {
  if (names.empty()) return;
  const double most = std::max(1.0, std::floor(room / needed_for_one));
  const auto every = static_cast<std::size_t>(std::ceil(static_cast<double>(names.size()) / most));
  axis.ticks.clear();
  for (std::size_t i = 0; i < names.size(); i += every) {
    axis.ticks.push_back({static_cast<double>(i + 1), names[i]});
  }
}

// The values that were swept, where all of them fit beside each other.
void centre_ticks(const FigureData& centres, double room, double per_line, Axis& axis) {
  std::vector<AxisTick> ticks;
  double needed = 0.0, nearest = room;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    ticks.push_back({centres[i], FigureText(fmt::format("{:g}", centres[i]))});
    needed = std::max(needed, per_line > 0.0 ? per_line : text_width(ticks.back().label) + 2.0 * kGap);
    if (i == 0) continue;
    const double gap = room * (share_of_axis(axis, centres[i]) - share_of_axis(axis, centres[i - 1]));
    nearest = std::min(nearest, std::abs(gap));
  }
  if (!ticks.empty() && needed <= nearest) axis.ticks = std::move(ticks);
}

const Series* heat_map_of(const Panel& panel) {
  const auto found = std::ranges::find(panel.series, SeriesKind::heat_map, &Series::kind);
  return found == panel.series.end() ? nullptr : &*found;
}

double widest_name(const std::vector<FigureText>& names) {
  double widest = 0.0;
  for (const FigureText& name : names) widest = std::max(widest, text_width(name));
  return widest;
}

double left_margin(const Panel& panel, const Axis& y) {
  const double label = panel.y_label.empty() ? 0.0 : kLine;
  return label + kGap + widest_label(y) + 13.0;
}

// From the axes to behind the tick labels of the colour bar.
double colour_bar_room(const Axis& colour) {
  return kColourBarGap + kColourBarWidth + 14.0 + widest_label(colour);
}

double right_margin(const Panel& panel, const Axis& colour) {
  if (!has_heat_map(panel)) return 16.0;
  return colour_bar_room(colour) + (panel.colour_label.empty() ? 0.0 : kLine) + kGap;
}

// A name of what is not there would be sought in vain. Of what has two ends the second one has no name.
bool is_named(const Panel& panel, std::size_t i) {
  const Series& series = panel.series[i];
  if (series.label.empty()) return false;
  bool shown = has_data(panel, series);
  for (++i; i < panel.series.size() && !shown; ++i) {
    const Series& other = panel.series[i];
    if (!other.label.empty() || other.role != series.role || other.kind != series.kind) break;
    shown = has_data(panel, other);
  }
  return shown;
}

std::vector<const Series*> named_series(const Panel& panel) {
  std::vector<const Series*> named;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    if (is_named(panel, i)) named.push_back(&panel.series[i]);
  }
  return named;
}

// Entries one behind the other, a new line where the next does not fit.
std::vector<LegendEntry> flow_legend(const Panel& panel, const CanvasBox& box, double cell_left, double top) {
  std::vector<LegendEntry> entries;
  double left = box.left;
  double widest = 0.0;
  for (const Series* const series : named_series(panel))
    widest = std::max(widest, kSample + kGap + text_width(series->label));
  if (widest > box.width()) left = std::max(cell_left + kGap, box.right - widest);
  double x = left;
  double y = top + 0.5 * kLine;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    if (!is_named(panel, i)) continue;
    const double width = kSample + kGap + text_width(series.label);
    if (x > left && x + width > box.right + kGap) {
      x = left;
      y += kLine;
    }
    entries.push_back({i, x, y, kSample});
    x += width + 2.5 * kGap;
  }
  return entries;
}

// Whether the sample of `told` has all that the one of `series` has: a marker on a line tells a line, too.
bool tells(const Series& told, const Series& series) {
  const LegendSample has = legend_sample(told), wants = legend_sample(series);
  return told.label == series.label && told.role == series.role && told.stroke == series.stroke &&
         told.marker == series.marker && has.area == wants.area && has.outline == wants.outline &&
         (has.line || !wants.line) && (has.marker || !wants.marker);
}

// Whether each panel has a legend of its own.
std::vector<bool> with_legends(const Figure& figure) {
  std::vector<bool> with;
  std::vector<const Series*> told;
  for (const Panel& panel : figure.panels) {
    const std::vector<const Series*> named = named_series(panel);
    const bool new_here =
        !std::ranges::equal(told, named, [](const Series* a, const Series* b) { return tells(*a, *b); });
    with.push_back(new_here && !named.empty());
    if (with.back()) told = named;
  }
  return with;
}

double legend_height(const std::vector<LegendEntry>& entries) {
  return entries.empty() ? 0.0 : entries.back().y - entries.front().y + kLine + 0.5 * kGap;
}

// Of axes beside which a vertical label has its place, though it is longer by a line at both ends.
double height_for(const FigureText& label) {
  constexpr double kMost = 500.0;
  return std::min(text_width(label) - 2.0 * kLine, kMost);
}

// Heights of the rows of axes: what the caller states, else a pleasant shape, else what a map needs; no less
// than their labels need.
double axes_height(const Figure& figure, const std::vector<PanelLayout>& panels, std::size_t row,
                   double width) {
  double height =
      figure.row_height > 0.0 ? figure.row_height * kLabelFont : std::clamp(0.62 * width, 130.0, 300.0);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (i / static_cast<std::size_t>(figure.cols) != row) continue;
    const Panel& panel = figure.panels[i];
    height = std::max({height, height_for(panel.y_label), height_for(panel.colour_label)});
    if (!panel.equal_aspect || figure.row_height > 0.0) continue;
    const AxisRange& x = panels[i].x.range;
    const AxisRange& y = panels[i].y.range;
    height = std::max(height, std::clamp((y.high - y.low) / (x.high - x.low), 0.45, 1.0) * width);
  }
  return height;
}

// Ranges, and ticks for a panel of usual size.
void start_axes(const Figure& figure, FigureLayout& layout) {
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const Panel& panel = figure.panels[i];
    PanelLayout& out = layout.panels[i];
    out.x = make_axis(x_range_of(panel), panel.log_x, 5);
    out.y = make_axis(y_range_of(panel), panel.log_y, 6);
    name_ticks(panel.y_names, kLine * static_cast<double>(panel.y_names.size()), kLine, out.y);
    out.has_colour_bar = has_heat_map(panel);
    out.colour_scale = panel.colour_scale;
    if (out.has_colour_bar) out.colour = make_axis(colour_range_of(panel), panel.log_colour, 5);
  }
}

// The columns of the grid: where their cells start, and the axes in them.
struct Columns {
  std::vector<double> cell_left, axes_left;
  double axes_width = 0.0;
};

Columns place_columns(const Figure& figure, const FigureLayout& layout) {
  const auto cols = static_cast<std::size_t>(figure.cols);
  std::vector<double> left(cols, 0.0);
  std::vector<double> right(cols, 0.0);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const std::size_t col = i % cols;
    left[col] = std::max(left[col], left_margin(figure.panels[i], layout.panels[i].y));
    right[col] = std::max(right[col], right_margin(figure.panels[i], layout.panels[i].colour));
  }
  const double margins =
      std::accumulate(left.begin(), left.end(), 0.0) + std::accumulate(right.begin(), right.end(), 0.0);
  constexpr double kNarrowest = 40.0;
  Columns columns;
  columns.axes_width = std::max((layout.width - margins) / static_cast<double>(cols), kNarrowest);
  double x = 0.0;
  for (std::size_t col = 0; col < cols; ++col) {
    columns.cell_left.push_back(x);
    columns.axes_left.push_back(x + left[col]);
    x += left[col] + columns.axes_width + right[col];
  }
  return columns;
}

// Places one panel whose axes lie between two depths below the top of the canvas.
void place_panel(const Panel& panel, PanelLayout& out, const Columns& columns, std::size_t col, double top,
                 double bottom) {
  const double width = columns.axes_width;
  const double left = columns.axes_left[col];
  out.box = {left, left + width, top, bottom};
  if (panel.equal_aspect) equalise(out.x.range, out.y.range, width / (bottom - top));
  out.x = make_x_axis(out.x.range, panel.log_x, width, has_whole_x(panel));
  out.y = make_axis(out.y.range, panel.log_y, wanted_y_ticks(bottom - top));
  if (const Series* heat = heat_map_of(panel); heat != nullptr) {
    if (panel.x_names.empty() && panel.ticks_at_centres) centre_ticks(heat->x, width, 0.0, out.x);
    if (panel.y_names.empty() && panel.ticks_at_centres) centre_ticks(heat->y, bottom - top, kLine, out.y);
  }
  name_ticks(panel.x_names, width, widest_name(panel.x_names) + 2.0 * kGap, out.x);
  name_ticks(panel.y_names, bottom - top, kLine, out.y);
  out.y_label_x = left - left_margin(panel, out.y) + 0.5 * kLine + 2.0;
  out.x_label_y = bottom + kTickLabels + 0.5 * kLine;
  out.title_y = top - 0.5 * kLine - 2.0;
  if (out.has_colour_bar) {
    out.colour = make_axis(out.colour.range, panel.log_colour, wanted_y_ticks(bottom - top));
    out.colour_bar_x = out.box.right + kColourBarGap;
    out.colour_label_x = out.box.right + colour_bar_room(out.colour) + 0.5 * kLine;
  }
}

// Places a row of the grid that starts at `depth` below the top; returns the depth of its end.
double place_row(const Figure& figure, FigureLayout& layout, const Columns& columns, std::size_t row,
                 double depth, const std::vector<bool>& legends_of) {
  const auto cols = static_cast<std::size_t>(figure.cols);
  const std::size_t begin = row * cols;
  const std::size_t end = std::min(figure.panels.size(), begin + cols);
  if (begin >= end) return depth;
  bool has_title = false;
  bool has_x_label = false;
  for (std::size_t i = begin; i < end; ++i) {
    has_title = has_title || !figure.panels[i].title.empty();
    has_x_label = has_x_label || !figure.panels[i].x_label.empty();
  }
  const double top = depth + (has_title ? kLine + 10.0 : 12.0);
  const double bottom = top + axes_height(figure, layout.panels, row, columns.axes_width);
  const double legend_top = bottom + kTickLabels + (has_x_label ? kLine + 1.0 : 0.0) + 3.0;
  double legends = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    PanelLayout& out = layout.panels[i];
    place_panel(figure.panels[i], out, columns, i - begin, top, bottom);
    if (legends_of[i])
      out.legend = flow_legend(figure.panels[i], out.box, columns.cell_left[i - begin], legend_top);
    legends = std::max(legends, legend_height(out.legend));
  }
  const double below = legend_top + legends + 2.0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t col = i - begin;
    const bool last = col + 1 == cols;
    layout.panels[i].cell = {columns.cell_left[col], last ? layout.width : columns.cell_left[col + 1], depth,
                             std::ceil(below)};
  }
  return below;
}

}  // namespace

LegendSample legend_sample(const Series& series) {
  const bool points = series.kind == SeriesKind::points;
  const bool area = series.kind == SeriesKind::band || (series.kind == SeriesKind::polygon && series.filled);
  const bool outline = series.kind == SeriesKind::polygon && !series.filled;
  return {.area = area,
          .line = !area && !outline && !points,
          .outline = outline,
          .marker = points || series.kind == SeriesKind::error_bars};
}

FigureLayout lay_out(const Figure& figure, double width) {
  FigureLayout layout;
  layout.width = width;
  layout.panels.resize(figure.panels.size());
  start_axes(figure, layout);
  const std::vector<bool> legends_of = with_legends(figure);
  // Margins follow from the labels of the ticks, and the ticks from the size that margins leave.
  for (int pass = 0; pass < 2; ++pass) {
    const Columns columns = place_columns(figure, layout);
    double depth = 0.0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(figure.rows); ++row) {
      depth = place_row(figure, layout, columns, row, depth, legends_of);
    }
    layout.height = std::ceil(depth);
  }
  return layout;
}

}  // namespace credence::internal
