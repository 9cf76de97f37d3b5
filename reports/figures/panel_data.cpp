#include "reports/figures/panel_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "core/append_item.h"
#include "reports/figures/figure_axis.h"
#include "reports/figures/figure_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr std::size_t kMostPoints = 1500;

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.5g}", value) : "null"; }

template <class Values>
std::string number_list(const Values& values, std::size_t every = 1) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); i += every) append_item(text, number(values[i]), ",");
  return "[" + text + "]";
}

/// A quoted JSON string that may stand within an element of HTML.
std::string json_text(std::string_view words) {
  std::string text;
  for (const char c : nlohmann::json(printable_line(words)).dump()) {
    text += c == '<' ? "\\u003c" : c == '&' ? "\\u0026" : std::string(1, c);
  }
  return text;
}

std::string words_of(const FigureText& text) {
  std::string words;
  for (const TextRun& run : text_runs(text)) {
    words += run.level == TextLevel::base ? "" : run.level == TextLevel::subscript ? "_" : "^";
    words += run.words;
  }
  return words;
}

bool has_points(const Series& s) {
  return s.kind == SeriesKind::line || s.kind == SeriesKind::steps || s.kind == SeriesKind::points ||
         s.kind == SeriesKind::band || s.kind == SeriesKind::error_bars;
}

bool increases(const FigureData& x) {
  double last = -std::numeric_limits<double>::infinity();
  for (const double value : x) {
    if (std::isnan(value)) continue;
    if (value < last) return false;
    last = value;
  }
  return true;
}

const char* mode_of(const Panel& panel) {
  if (has_heat_map(panel)) return "cells";
  const bool columns =
      std::ranges::all_of(panel.series, [](const Series& s) { return !has_points(s) || increases(s.x); });
  return columns && !panel.equal_aspect ? "column" : "near";
}

/// The abscissae that were met, each written once.
class SharedColumns {
 public:
  std::size_t index_of(const FigureData& x, std::size_t every) {
    const auto [place, is_new] = index_.try_emplace(column(x, every), index_.size());
    if (is_new) append_item(text_, place->first, ",");
    return place->second;
  }
  std::string text() const { return "[" + text_ + "]"; }

 private:
  static std::string column(const FigureData& x, std::size_t every) {
    if (x.size() < 4) return number_list(x, every);
    const double by = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
    const double least = 1e-9 * std::max(std::abs(x.front()), std::abs(x.back()));
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!(std::abs(x[i] - x.front() - by * static_cast<double>(i)) <= least)) return number_list(x, every);
    }
    return fmt::format("{{\"from\":{:.10g},\"by\":{:.10g},\"n\":{}}}", x.front(),
                       by * static_cast<double>(every), (x.size() - 1) / every + 1);
  }

  std::map<std::string, std::size_t> index_;
  std::string text_;
};

std::string series_text(const Panel& panel, const std::vector<std::size_t>& leading, SharedColumns& columns) {
  std::string text;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& s = panel.series[i];
    if (!has_points(s) || s.label.empty() || s.x.empty()) continue;
    // A named line and the unnamed one behind it, the two ends of one thing.
    const bool pair = s.kind == SeriesKind::line && i + 1 < panel.series.size() && leading[i + 1] == i &&
                      panel.series[i + 1].x == s.x;
    const bool band = pair || s.kind == SeriesKind::band;
    const std::size_t every = s.x.size() / kMostPoints + 1;
    append_item(text,
                fmt::format("{{\"i\":{},\"n\":{},\"c\":\"#{:06x}\",\"x\":{}", i, json_text(words_of(s.label)),
                            style_of(s.role).rgb, columns.index_of(s.x, every)),
                ",");
    if (!band) text += ",\"y\":" + number_list(s.y, every);
    if (pair)
      text += ",\"l\":" + number_list(s.y, every) + ",\"u\":" + number_list(panel.series[i + 1].y, every);
    if (!pair && !s.lower.empty()) {
      text += ",\"l\":" + number_list(s.lower, every) + ",\"u\":" + number_list(s.upper, every);
    }
    text += '}';
  }
  return "[" + text + "]";
}

std::string parts_text(const Panel& panel, const std::vector<std::size_t>& leading) {
  std::string text;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    if (panel.series[i].label.empty()) continue;
    std::string parts;
    for (std::size_t k = 0; k < leading.size(); ++k) {
      if (leading[k] == i) append_item(parts, std::to_string(k), ",");
    }
    append_item(text, fmt::format("\"{}\":[{}]", i, parts), ",");
  }
  return "{" + text + "}";
}

std::string names_text(const std::vector<FigureText>& names) {
  std::string text;
  for (const FigureText& name : names) append_item(text, json_text(words_of(name)), ",");
  return "[" + text + "]";
}

std::string cells_text(const Panel& panel) {
  for (const Series& s : panel.series) {
    if (s.kind != SeriesKind::heat_map) continue;
    std::string rows;
    for (Index i = 0; i < s.cells.rows(); ++i) {
      append_item(rows, number_list(std::vector<double>(s.cells.row(i).begin(), s.cells.row(i).end())), ",");
    }
    std::string text = fmt::format("{{\"x\":{},\"y\":{},\"xe\":{},\"ye\":{},\"v\":[{}]", number_list(s.x),
                                   number_list(s.y), number_list(cell_edges(s.x, panel.log_x)),
                                   number_list(cell_edges(s.y, panel.log_y)), rows);
    if (!panel.x_names.empty()) text += ",\"xn\":" + names_text(panel.x_names);
    if (!panel.y_names.empty()) text += ",\"yn\":" + names_text(panel.y_names);
    return text + "}";
  }
  return "null";
}

std::string axis_text(const Axis& axis) {
  return fmt::format("[{:.10g},{:.10g},{}]", axis.range.low, axis.range.high, axis.log ? 1 : 0);
}

}  // namespace

std::vector<std::size_t> leading_series(const Panel& panel) {
  std::vector<std::size_t> leading(panel.series.size());
  for (std::size_t i = 0; i < leading.size(); ++i) {
    const Series& s = panel.series[i];
    leading[i] = i;
    if (!s.label.empty()) continue;
    const bool before = i > 0 && panel.series[i - 1].role == s.role && panel.series[i - 1].kind == s.kind;
    const bool behind = i + 1 < leading.size() && panel.series[i + 1].role == s.role &&
                        panel.series[i + 1].x == s.x && panel.series[i + 1].y == s.y;
    if (before && !panel.series[leading[i - 1]].label.empty()) leading[i] = leading[i - 1];
    if (behind) leading[i] = i + 1;
  }
  return leading;
}

std::string panel_data(const Panel& panel, const PanelLayout& layout) {
  const std::vector<std::size_t> leading = leading_series(panel);
  SharedColumns columns;
  const std::string series = series_text(panel, leading, columns);
  const CanvasBox& box = layout.box;
  return fmt::format(
      "{{\"box\":[{:.2f},{:.2f},{:.2f},{:.2f}],\"x\":{},\"y\":{},\"title\":{},\"xLabel\":{},\"yLabel\":{},"
      "\"valueLabel\":{},\"mode\":\"{}\",\"columns\":{},\"series\":{},\"parts\":{},\"cells\":{}}}",
      box.left, box.right, box.top, box.bottom, axis_text(layout.x), axis_text(layout.y),
      json_text(words_of(panel.title)), json_text(words_of(panel.x_label)),
      json_text(words_of(panel.y_label)), json_text(words_of(panel.colour_label)), mode_of(panel),
      columns.text(), series, parts_text(panel, leading), cells_text(panel));
}

}  // namespace credence::internal
