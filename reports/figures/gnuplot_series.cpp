#include "reports/figures/gnuplot_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace credence {
namespace {

// Series with more points are thinned to what the pixels can show.
constexpr std::size_t kDecimateAbove = 2000;

int marker_type(MarkerShape shape) {
  switch (shape) {
    case MarkerShape::plus:
      return 1;
    case MarkerShape::cross:
      return 2;
    case MarkerShape::square:
      return 5;
    case MarkerShape::triangle:
      return 9;
    case MarkerShape::diamond:
      return 13;
    case MarkerShape::dot:
    case MarkerShape::by_role:
      break;
  }
  return 7;
}

std::string area(const Series& series) {
  const RoleStyle style = style_of(series.role);
  return fmt::format("with filledcurves closed fc {} fs transparent solid {:.3g} noborder",
                     gnuplot_colour(style.rgb), style.tint);
}

std::vector<double> scaled(std::vector<double> values, bool log) {
  if (log) std::transform(values.begin(), values.end(), values.begin(), [](double v) { return std::log(v); });
  return values;
}

PixelBox pixels(const PanelLayout& layout) {
  const auto at = [](double value, bool log) { return log ? std::log(value) : value; };
  return {at(layout.x.range.low, layout.x.log),
          at(layout.x.range.high, layout.x.log),
          at(layout.y.range.low, layout.y.log),
          at(layout.y.range.high, layout.y.log),
          static_cast<int>(std::ceil(layout.box.width())),
          static_cast<int>(std::ceil(layout.box.height()))};
}

using Keep = std::vector<std::size_t> (*)(const std::vector<double>&, const std::vector<double>&,
                                          const PixelBox&);

// The points of `piece` that `keep` chooses, judged in the coordinates of the (maybe logarithmic) axes.
CurvePiece thinned(const CurvePiece& piece, const PanelLayout& layout, Keep keep) {
  CurvePiece kept;
  for (const std::size_t i :
       keep(scaled(piece.x, layout.x.log), scaled(piece.y, layout.y.log), pixels(layout))) {
    kept.x.push_back(piece.x[i]);
    kept.y.push_back(piece.y[i]);
  }
  return kept;
}

std::vector<CurvePiece> visible(const Series& series, const PanelLayout& layout) {
  auto pieces = finite_pieces(series.x, series.y, layout.x.log, layout.y.log);
  if (series.x.size() <= kDecimateAbove) return pieces;
  const bool cloud = series.kind == SeriesKind::points || series.kind == SeriesKind::error_bars;
  for (CurvePiece& piece : pieces) {
    const bool forward = std::is_sorted(piece.x.begin(), piece.x.end());
    piece = thinned(piece, layout, cloud ? keep_by_pixel : forward ? keep_by_column : keep_by_distance);
  }
  return pieces;
}

}  // namespace

std::string gnuplot_colour(std::uint32_t rgb) { return fmt::format("rgb '#{:06x}'", rgb); }

std::string gnuplot_line(const Series& series) {
  const RoleStyle style = style_of(series.role);
  const StrokeStyle stroke = series.stroke == StrokeStyle::by_role ? style.stroke : series.stroke;
  const char* dash = stroke == StrokeStyle::dashed   ? "(10,6)"
                     : stroke == StrokeStyle::dotted ? "(3,4)"
                                                     : "solid";
  return fmt::format("lw {:.3g} lc {} dt {}", style.width * series.weight, gnuplot_colour(style.rgb), dash);
}

std::string gnuplot_marker(const Series& series) {
  const RoleStyle style = style_of(series.role);
  const int type = marker_type(series.marker == MarkerShape::by_role ? style.marker : series.marker);
  // Crosses and pluses have no area and are drawn larger.
  const double size = type <= 2 ? 0.8 : type == 7 ? 0.42 : 0.6;
  return fmt::format("pt {} ps {:.3g} lw 1.2 lc {}", type, size * series.weight, gnuplot_colour(style.rgb));
}

void PlotWriter::add(const Series& series, const PanelLayout& layout) {
  const AxisRange x = layout.x.range;
  const AxisRange y = layout.y.range;
  const auto straight = [&](const std::vector<double>& xs, const std::vector<double>& ys) {
    add_curves(finite_pieces(xs, ys, layout.x.log, layout.y.log), "with lines " + gnuplot_line(series));
  };
  switch (series.kind) {
    case SeriesKind::line:
      return add_line(series, layout, "with lines ");
    case SeriesKind::steps:
      return add_line(series, layout, "with steps ");
    case SeriesKind::points:
      return add_curves(visible(series, layout), "with points " + gnuplot_marker(series));
    case SeriesKind::level:
      return straight({x.low, x.high}, {series.y[0], series.y[0]});
    case SeriesKind::upright:
      return straight({series.x[0], series.x[0]}, {y.low, y.high});
    case SeriesKind::error_bars:
      return add_error_bars(series, layout);
    case SeriesKind::band:
      return add_band(series, layout);
    case SeriesKind::polygon:
      return add_polygons(series, layout);
    case SeriesKind::heat_map:
      return add_heat_map(series, layout);
    case SeriesKind::text:
      return;
  }
}

std::vector<std::string> PlotWriter::take_elements(const PanelLayout& layout) {
  if (elements_.empty()) add_curves({{{layout.x.range.low}, {layout.y.range.low}}}, "with lines");
  return std::exchange(elements_, {});
}

// A blank line in a data block breaks the curve.
void PlotWriter::add_curves(const std::vector<CurvePiece>& pieces, const std::string& style) {
  if (pieces.empty()) return;
  const auto out = std::back_inserter(data_);
  fmt::format_to(out, "$d{} << END\n", blocks_);
  for (const CurvePiece& piece : pieces) {
    for (std::size_t i = 0; i < piece.x.size(); ++i) {
      fmt::format_to(out, "{:.10g} {:.10g}\n", piece.x[i], piece.y[i]);
    }
    data_ += '\n';
  }
  data_ += "END\n";
  elements_.push_back(fmt::format("$d{} {} notitle", blocks_++, style));
}

// A point without neighbours has no line; it is shown by a marker.
void PlotWriter::add_line(const Series& series, const PanelLayout& layout, const std::string& style) {
  const auto pieces = visible(series, layout);
  std::vector<CurvePiece> lone;
  std::copy_if(pieces.begin(), pieces.end(), std::back_inserter(lone),
               [](const CurvePiece& piece) { return piece.x.size() == 1; });
  add_curves(pieces, style + gnuplot_line(series));
  add_curves(lone, "with points " + gnuplot_marker(series));
}

void PlotWriter::add_error_bars(const Series& series, const PanelLayout& layout) {
  std::vector<CurvePiece> bars;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const auto bar = finite_pieces({series.x[i], series.x[i]}, {series.lower[i], series.upper[i]},
                                   layout.x.log, layout.y.log);
    if (bar.size() == 1 && bar[0].x.size() == 2) bars.push_back(bar[0]);
  }
  add_curves(bars, "with lines " + gnuplot_line(series));
  add_curves(visible(series, layout), "with points " + gnuplot_marker(series));
}

// Each unbroken stretch becomes a polygon: forth along the upper curve, back along the lower one.
void PlotWriter::add_band(const Series& series, const PanelLayout& layout) {
  std::vector<CurvePiece> outlines;
  const auto usable = [&](std::size_t i) {
    const auto fits = [](double value, bool log) { return std::isfinite(value) && (!log || value > 0.0); };
    return fits(series.x[i], layout.x.log) && fits(series.lower[i], layout.y.log) &&
           fits(series.upper[i], layout.y.log);
  };
  for (std::size_t i = 0; i < series.x.size();) {
    CurvePiece forth;
    CurvePiece back;
    for (; i < series.x.size() && usable(i); ++i) {
      forth.x.push_back(series.x[i]);
      forth.y.push_back(series.upper[i]);
      back.x.push_back(series.x[i]);
      back.y.push_back(series.lower[i]);
    }
    if (forth.x.empty()) {
      ++i;
      continue;
    }
    if (series.x.size() > kDecimateAbove) {
      forth = thinned(forth, layout, keep_by_column);
      back = thinned(back, layout, keep_by_column);
    }
    forth.x.insert(forth.x.end(), back.x.rbegin(), back.x.rend());
    forth.y.insert(forth.y.end(), back.y.rbegin(), back.y.rend());
    outlines.push_back(std::move(forth));
  }
  add_curves(outlines, area(series));
}

void PlotWriter::add_polygons(const Series& series, const PanelLayout& layout) {
  auto outlines = visible(series, layout);
  for (CurvePiece& outline : outlines) {
    outline.x.push_back(outline.x.front());
    outline.y.push_back(outline.y.front());
  }
  if (series.filled) add_curves(outlines, area(series));
  add_curves(outlines, "with lines " + gnuplot_line(series));
}

void PlotWriter::add_heat_map(const Series& series, const PanelLayout& layout) {
  const std::vector<double> x_edges = cell_edges(series.x, layout.x.log);
  const std::vector<double> y_edges = cell_edges(series.y, layout.y.log);
  const AxisRange scale = layout.colour.range;
  std::string known;
  std::string missing;
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    for (std::size_t j = 0; j < series.x.size(); ++j) {
      const double value = series.cells(static_cast<Index>(i), static_cast<Index>(j));
      const bool has_value = std::isfinite(value) && (!layout.colour.log || value > 0.0);
      std::string& rows = has_value ? known : missing;
      fmt::format_to(std::back_inserter(rows), "{:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}", series.x[j],
                     series.y[i], x_edges[j], x_edges[j + 1], y_edges[i], y_edges[i + 1]);
      // Beyond the scale a cell takes the colour of its end.
      if (has_value)
        fmt::format_to(std::back_inserter(rows), " {:.10g}", std::clamp(value, scale.low, scale.high));
      rows += '\n';
    }
  }
  add_cells(missing, fmt::format("using 1:2:3:4:5:6 with boxxyerror fc {}", gnuplot_colour(kMissingColour)));
  add_cells(known, "using 1:2:3:4:5:6:7 with boxxyerror fc palette");
}

void PlotWriter::add_cells(const std::string& rows, const std::string& style) {
  if (rows.empty()) return;
  data_ += fmt::format("$d{} << END\n{}END\n", blocks_, rows);
  elements_.push_back(fmt::format("$d{} {} fs solid 1 noborder notitle", blocks_++, style));
}

}  // namespace credence
