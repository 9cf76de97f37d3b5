#include "reports/figures/figure_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "core/nan.h"
#include "reports/figures/figure_text.h"

namespace credence::internal {
namespace {

// Magnitudes that a plot cannot place in double arithmetic (differences overflow) count as not finite.
constexpr double kLargest = 1e300;

// The smallest interval that holds all usable values.
class Hull {
 public:
  explicit Hull(bool log) : log_(log) {}
  void add(double value) {
    if (!std::isfinite(value) || std::abs(value) > kLargest || (log_ && value < 1.0 / kLargest)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
  }
  // `room` is the share of the interval left free at each end.
  AxisRange range(double room) const {
    if (low_ > high_) return log_ ? AxisRange{0.1, 10.0} : AxisRange{0.0, 1.0};
    if (log_) {
      const double factor = low_ == high_ ? 2.0 : std::exp(room * (std::log(high_) - std::log(low_)));
      return {std::max(low_ / factor, 1.0 / kLargest), std::min(high_ * factor, kLargest)};
    }
    // A constant curve still deserves an axis with ticks that differ.
    const double flat = low_ == 0.0 ? 1.0 : 0.1 * std::abs(low_);
    const bool constant = high_ - low_ <= 1e-12 * std::max(std::abs(low_), std::abs(high_));
    const double margin = constant ? flat : room * (high_ - low_);
    return {low_ - margin, high_ + margin};
  }

 private:
  bool log_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

// Curves over time start and end at the frame; clouds and maps need room.
bool fills_the_width(const Panel& panel) {
  return std::ranges::any_of(panel.series, [](const Series& series) {
    return series.kind == SeriesKind::line || series.kind == SeriesKind::steps ||
           series.kind == SeriesKind::band;
  });
}

// "0.25", "−3", "2×10⁵": every label of an axis with the decimals that its step needs.
FigureText tick_label(double value, double step, double largest) {
  constexpr double kSmallestPlainStep = 1e-4;
  constexpr double kLargestPlain = 1e7;
  const char* sign = value < 0.0 ? "\u2212" : "";
  const double magnitude = std::abs(value);
  if (step >= kSmallestPlainStep && largest < kLargestPlain) {
    const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    return FigureText(fmt::format("{}{:.{}f}", sign, magnitude, decimals));
  }
  if (magnitude == 0.0) return "0";
  const double exponent = std::floor(std::log10(largest) + 1e-9);
  const double unit = std::pow(10.0, exponent);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step / unit) + 1e-9)));
  return figure_markup(fmt::format("{}{:.{}f}×10^{{{}{}}}", sign, magnitude / unit, decimals,
                                   exponent < 0 ? "\u2212" : "", std::abs(exponent)));
}

std::vector<AxisTick> linear_ticks(AxisRange range, int wanted, bool whole = false) {
  const double raw = (range.high - range.low) / std::max(1, wanted);
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * decade;
  // A few ticks more than wanted are better than half of them.
  constexpr double kEager = 0.8;
  for (const double round : {1.0, 2.0, 5.0}) {
    if (round * decade >= kEager * raw) {
      step = round * decade;
      break;
    }
  }
  if (whole) step = std::max(step, 1.0);
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  const double slack = 1e-9 * (range.high - range.low);
  std::vector<AxisTick> ticks;
  // Where rounding swallows the step, no tick is better than an endless loop.
  const double first = std::ceil((range.low - slack) / step);
  const double last = std::floor((range.high + slack) / step);
  for (double k = first; k <= last && ticks.size() < 50; k += 1.0) {
    const double value = k == 0.0 ? 0.0 : k * step;
    ticks.push_back({value, tick_label(value, step, largest)});
  }
  return ticks;
}

constexpr std::size_t kFewestTicks = 3;  // fewer are too few to read an axis by

FigureText log_label(double mantissa, int exponent, bool as_power) {
  const int more = mantissa == std::floor(mantissa) ? 0 : 1;
  if (!as_power) {
    return FigureText(
        fmt::format("{:.{}f}", mantissa * std::pow(10.0, exponent), std::max(0, more - exponent)));
  }
  const std::string power = fmt::format("10^{{{}{}}}", exponent < 0 ? "\u2212" : "", std::abs(exponent));
  return figure_markup(mantissa == 1.0 ? power : fmt::format("{:.{}f}×{}", mantissa, more, power));
}

/// Evenly spread, for less than half a decade.
std::vector<AxisTick> short_log_ticks(AxisRange range, int wanted) {
  constexpr int kMore = 5;
  std::vector<AxisTick> ticks;
  for (int more = 0; more <= kMore && ticks.size() < kFewestTicks; ++more) {
    ticks = linear_ticks(range, wanted + more);
  }
  return ticks;
}

std::vector<AxisTick> log_ticks(AxisRange range, int wanted) {
  const double decades = std::log10(range.high) - std::log10(range.low);
  if (decades < 0.5) return short_log_ticks(range, wanted);
  const int first = static_cast<int>(std::floor(std::log10(range.low)));
  const int last = static_cast<int>(std::ceil(std::log10(range.high)));
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / std::max(1, wanted))));
  const bool with_2_and_5 = decades * 3.0 <= wanted + 1.0 || decades < 1.35;
  // All labels of an axis are powers, or none.
  const bool as_power = range.low < 0.99e-3 || range.high > 2e4;
  const auto at = [&](std::initializer_list<double> mantissas) {
    std::vector<AxisTick> ticks;
    for (int exponent = first; exponent <= last; ++exponent) {
      for (const double mantissa : mantissas) {
        const double value = mantissa * std::pow(10.0, exponent);
        const bool chosen = mantissa == 1.0 ? exponent % stride == 0 : with_2_and_5;
        if (chosen && value >= range.low * (1 - 1e-9) && value <= range.high * (1 + 1e-9)) {
          ticks.push_back({value, log_label(mantissa, exponent, as_power)});
        }
      }
    }
    return ticks;
  };
  std::vector<AxisTick> ticks = at({1.0, 2.0, 5.0});
  if (!with_2_and_5 || ticks.size() >= kFewestTicks) return ticks;
  ticks = at({1.0, 2.0, 3.0, 5.0});
  // Half a decade holds three of these at least.
  if (ticks.size() < kFewestTicks) ticks = at({1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0});
  return ticks;
}

}  // namespace

bool has_heat_map(const Panel& panel) {
  return std::ranges::find(panel.series, SeriesKind::heat_map, &Series::kind) != panel.series.end();
}

Axis make_axis(AxisRange range, bool log, int wanted, bool whole) {
  return {range, log, log ? log_ticks(range, wanted) : linear_ticks(range, wanted, whole)};
}

bool has_whole_x(const Panel& panel) {
  std::size_t values = 0;
  for (const Series& series : panel.series) {
    for (const double x : series.x) {
      if (!std::isfinite(x)) continue;
      if (x != std::round(x)) return false;
      ++values;
    }
  }
  return values > 0;
}

AxisRange x_range_of(const Panel& panel) {
  if (panel.x_range) return *panel.x_range;
  Hull hull(panel.log_x);
  for (const Series& series : panel.series) {
    hull.add(series.kind == SeriesKind::heat_map ? cell_edges(series.x, panel.log_x)
                                                 : std::vector<double>(series.x));
  }
  const double room = panel.equal_aspect ? 0.05 : fills_the_width(panel) ? 0.0 : 0.02;
  return hull.range(has_heat_map(panel) ? 0.0 : room);
}

AxisRange y_range_of(const Panel& panel) {
  if (panel.y_range) return *panel.y_range;
  Hull hull(panel.log_y);
  for (const Series& series : panel.series) {
    hull.add(series.kind == SeriesKind::heat_map ? cell_edges(series.y, panel.log_y)
                                                 : std::vector<double>(series.y));
    hull.add(series.lower);
    hull.add(series.upper);
  }
  return hull.range(has_heat_map(panel) ? 0.0 : 0.05);
}

AxisRange colour_range_of(const Panel& panel) {
  if (panel.colour_range) return *panel.colour_range;
  Hull hull(panel.log_colour);
  for (const Series& series : panel.series) {
    for (Index i = 0; i < series.cells.size(); ++i) hull.add(series.cells.data()[i]);
  }
  return hull.range(0.0);
}

void leave_out_start(Figure& figure, bool bounds_alone) {
  constexpr std::ptrdiff_t kStart = 10;
  constexpr double kMuchLonger = 2.0;
  bool beyond = false;
  for (Panel& panel : figure.panels) {
    if (panel.log_y || panel.y_range) continue;
    Panel rest = panel;
    for (Series& series : rest.series) {
      if (bounds_alone && series.role != ColourRole::bound) continue;
      for (FigureData* values : {&series.y, &series.lower, &series.upper}) {
        const auto first = std::ranges::find_if(*values, [](double v) { return std::isfinite(v); });
        std::fill(first, first + (values->end() - first) / kStart, kNaN);
      }
    }
    const AxisRange whole = y_range_of(panel), needed = y_range_of(rest);
    if (whole.high - whole.low <= kMuchLonger * (needed.high - needed.low)) continue;
    panel.y_range = needed;
    beyond = true;
  }
  if (beyond) figure.caption += " What the first steps alone need lies beyond the axes.";
}

std::vector<double> cell_edges(const FigureData& centres, bool log) {
  std::vector<double> at(centres);
  if (log) std::ranges::transform(at, at.begin(), [](double v) { return std::log(v); });
  std::vector<double> edges;
  const std::size_t n = at.size();
  if (n == 1) edges = {at[0] - 0.5, at[0] + 0.5};
  if (n > 1) {
    edges.push_back(at[0] - 0.5 * (at[1] - at[0]));
    for (std::size_t i = 1; i < n; ++i) edges.push_back(0.5 * (at[i - 1] + at[i]));
    edges.push_back(at[n - 1] + 0.5 * (at[n - 1] - at[n - 2]));
  }
  if (log) std::ranges::transform(edges, edges.begin(), [](double v) { return std::exp(v); });
  return edges;
}

void equalise(AxisRange& x, AxisRange& y, double width_over_height) {
  const double x_span = x.high - x.low;
  const double y_span = y.high - y.low;
  const double wanted_x = std::max(x_span, y_span * width_over_height);
  const double wanted_y = wanted_x / width_over_height;
  const double x_more = 0.5 * (wanted_x - x_span);
  const double y_more = 0.5 * (wanted_y - y_span);
  x = {x.low - x_more, x.high + x_more};
  y = {y.low - y_more, y.high + y_more};
}

double widest_label(const Axis& axis) {
  double widest = 0.0;
  for (const AxisTick& tick : axis.ticks) widest = std::max(widest, text_width(tick.label));
  return widest;
}

}  // namespace credence::internal
