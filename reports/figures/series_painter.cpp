#include "reports/figures/series_painter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "reports/figures/figure_clip.h"
#include "reports/figures/figure_decimation.h"
#include "reports/figures/figure_marker.h"
#include "reports/figures/figure_style.h"
#include "reports/figures/figure_text.h"

namespace credence::internal {
namespace {

// Longer curves are thinned to what the pixels can show.
constexpr std::size_t kThinAbove = 500;
// What no eye and no printer tells from a straight line.
constexpr double kStraight = 0.05;
// Half the width that a lone point of a band or of a dashed or dotted line is drawn with.
constexpr double kLonePoint = 0.75;

constexpr std::uint32_t kDarkWords = 0x000000, kLightWords = 0xffffff;

/// By the luma of ITU-R BT.601.
bool is_dark(std::uint32_t rgb) {
  const std::uint32_t red = rgb >> 16U & 0xffU, green = rgb >> 8U & 0xffU, blue = rgb & 0xffU;
  return 299U * red + 587U * green + 114U * blue < 1000U * 140U;
}

Pen pen_of(const Series& series) {
  const RoleStyle style = style_of(series.role);
  return {.rgb = style.rgb,
          .width = style.width * series.weight,
          .stroke = series.stroke == StrokeStyle::by_role ? style.stroke : series.stroke};
}

CanvasPath thinned(CanvasPath curve) {
  if (curve.size() > kThinAbove) {
    curve = std::ranges::is_sorted(curve, {}, &CanvasPoint::x) ? thin_columns(curve) : thin_distances(curve);
  }
  return straighten(curve, kStraight);
}

// y_i holds up to x_{i+1}.
CanvasPath staircase(const CanvasPath& curve) {
  CanvasPath steps;
  for (const CanvasPoint& point : curve) {
    if (!steps.empty()) steps.push_back({point.x, steps.back().y});
    steps.push_back(point);
  }
  return steps;
}

CanvasPath ellipse_path(const CanvasPoint& middle, double half_width, double half_height) {
  constexpr int kCorners = 32;
  CanvasPath path;
  for (int i = 0; i <= kCorners; ++i) {
    const double t = 2.0 * std::numbers::pi * i / kCorners;
    path.push_back({middle.x + half_width * std::cos(t), middle.y + half_height * std::sin(t)});
  }
  return path;
}

CanvasPath widened(const CanvasPath& point) {
  const CanvasPoint at = point.front();
  return {{at.x - kLonePoint, at.y}, {at.x + kLonePoint, at.y}};
}

}  // namespace

void SeriesPainter::paint(const Series& series) {
  const AxisRange& x = layout_.x.range;
  const AxisRange& y = layout_.y.range;
  switch (series.kind) {
    case SeriesKind::line:
    case SeriesKind::steps: return curve(series);
    case SeriesKind::points: return markers(series, curves(series, series.x, series.y));
    case SeriesKind::level:
      return lines(pen_of(series), scale_.curves({x.low, x.high}, {series.y[0], series.y[0]}));
    case SeriesKind::upright:
      return lines(pen_of(series), scale_.curves({series.x[0], series.x[0]}, {y.low, y.high}));
    case SeriesKind::error_bars: return error_bars(series);
    case SeriesKind::band: return band(series);
    case SeriesKind::polygon: return polygons(series);
    case SeriesKind::text: return words(series);
    case SeriesKind::heat_map: return cells(series);
  }
}

void SeriesPainter::paint_sample(const Series& series, const LegendEntry& entry) {
  const double end = entry.x + entry.sample_width;
  const CanvasPath middle{{0.5 * (entry.x + end), entry.y}};
  const LegendSample sample = legend_sample(series);
  if (sample.area) {
    const RoleStyle style = style_of(series.role);
    const CanvasPath box = rectangle_path({entry.x, end, entry.y - 5.0, entry.y + 5.0});
    return canvas_.fill({&box, 1}, {style.rgb, style.tint});
  }
  if (sample.line) {
    const CanvasPath line{{entry.x, entry.y}, {end, entry.y}};
    canvas_.stroke({&line, 1}, pen_of(series));
  }
  if (sample.outline) {
    const CanvasPath ellipse = ellipse_path(middle.front(), 0.4 * entry.sample_width, 4.5);
    canvas_.stroke({&ellipse, 1}, pen_of(series));
  }
  if (sample.marker) paint_markers(series, middle, canvas_);
}

std::vector<CanvasPath> SeriesPainter::curves(const Series& series, const FigureData& x,
                                              const FigureData& y) const {
  std::vector<CanvasPath> curves = scale_.curves(x, y);
  for (CanvasPath& curve : curves) {
    for (CanvasPoint& point : curve) point.x += series.aside;
  }
  return curves;
}

void SeriesPainter::lines(const Pen& pen, const std::vector<CanvasPath>& curves) {
  std::vector<CanvasPath> seen;
  for (const CanvasPath& curve : curves) {
    for (CanvasPath& piece : clip_line(curve, layout_.box)) {
      if (piece.size() > 1) seen.push_back(std::move(piece));
    }
  }
  if (seen.empty()) return;
  canvas_.stroke(seen, pen);
  has_painted_ = true;
}

void SeriesPainter::markers(const Series& series, const std::vector<CanvasPath>& places) {
  CanvasPath seen;
  for (const CanvasPath& piece : places) {
    std::ranges::copy_if(piece, std::back_inserter(seen),
                         [&](const CanvasPoint& place) { return is_inside(place, layout_.box); });
  }
  if (seen.empty()) return;
  if (seen.size() > kThinAbove) seen = thin_cloud(seen);
  paint_markers(series, seen, canvas_, !cells_.empty());
  has_painted_ = true;
}

void SeriesPainter::areas(const Series& series, const std::vector<CanvasPath>& outlines) {
  std::vector<CanvasPath> seen;
  for (const CanvasPath& outline : outlines) {
    CanvasPath inside = clip_area(outline, layout_.box);
    if (inside.size() > 2) seen.push_back(std::move(inside));
  }
  if (seen.empty()) return;
  const RoleStyle style = style_of(series.role);
  canvas_.fill(seen, {style.rgb, style.tint});
  has_painted_ = true;
}

// A point without neighbours has no line; it is shown by a marker or, of what is expected or accepted, by a
// stroke as short: markers would look like data.
void SeriesPainter::curve(const Series& series) {
  std::vector<CanvasPath> joined;
  std::vector<CanvasPath> lone;
  const std::vector<CanvasPath> pieces = curves(series, series.x, series.y);
  const bool by_marker = pen_of(series).stroke == StrokeStyle::solid || pieces.size() == 1;
  for (const CanvasPath& curve : pieces) {
    if (curve.size() == 1) {
      if (by_marker) {
        lone.push_back(curve);
      } else {
        joined.push_back(widened(curve));
      }
    } else {
      joined.push_back(thinned(series.kind == SeriesKind::steps ? staircase(curve) : curve));
    }
  }
  lines(pen_of(series), joined);
  markers(series, lone);
}

void SeriesPainter::error_bars(const Series& series) {
  std::vector<CanvasPath> bars;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const auto bar = curves(series, {series.x[i], series.x[i]}, {series.lower[i], series.upper[i]});
    if (bar.size() == 1 && bar[0].size() == 2) bars.push_back(bar[0]);
  }
  Pen pen = pen_of(series);
  pen.stroke = StrokeStyle::solid;  // dashes tear short bars apart
  lines(pen, bars);
  markers(series, curves(series, series.x, series.y));
}

// Each unbroken stretch is an area: forth along the upper curve, back along the lower one.
void SeriesPainter::band(const Series& series) {
  std::vector<CanvasPath> outlines;
  CanvasPath upper;
  CanvasPath lower;
  const auto close = [&] {
    if (upper.empty()) return;
    if (upper.size() == 1) {
      upper = widened(upper);
      lower = widened(lower);
    }
    CanvasPath outline = thinned(std::exchange(upper, {}));
    const CanvasPath back = thinned(std::exchange(lower, {}));
    outline.insert(outline.end(), back.rbegin(), back.rend());
    outlines.push_back(std::move(outline));
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double x = scale_.x(series.x[i]);
    const CanvasPoint above{x, scale_.y(series.upper[i])};
    const CanvasPoint below{x, scale_.y(series.lower[i])};
    if (std::isnan(x) || std::isnan(above.y) || std::isnan(below.y)) {
      close();
    } else {
      upper.push_back(above);
      lower.push_back(below);
    }
  }
  close();
  areas(series, outlines);
}

void SeriesPainter::polygons(const Series& series) {
  std::vector<CanvasPath> outlines = scale_.curves(series.x, series.y);
  for (CanvasPath& outline : outlines) {
    outline.push_back(outline.front());
    outline = thinned(std::move(outline));
  }
  if (series.filled) areas(series, outlines);
  lines(pen_of(series), outlines);
}

void SeriesPainter::keep_clear(const Panel& panel) {
  constexpr double kReach = 4.0;      // of a marker
  constexpr std::size_t kMost = 500;  // of more there is no place without
  const auto has_words = [](const Series& series) { return series.kind == SeriesKind::text; };
  if (std::ranges::none_of(panel.series, has_words)) return;
  for (const Series& series : panel.series) {
    const bool bars = series.kind == SeriesKind::error_bars;
    if (!bars && series.kind != SeriesKind::points) continue;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const double x = scale_.x(series.x[i]) + series.aside, y = scale_.y(series.y[i]);
      if (std::isnan(x)) continue;
      if (!std::isnan(y)) markers_.push_back({x - kReach, x + kReach, y - kReach, y + kReach});
      if (!bars) continue;
      const double top = scale_.y(series.upper[i]), bottom = scale_.y(series.lower[i]);
      if (!std::isnan(top) && !std::isnan(bottom)) bars_.push_back({x - 1.0, x + 1.0, top, bottom});
    }
  }
  if (markers_.size() > kMost) markers_.clear();
}

// The corners of the point, then rings around it; in doubt what is nearer.
std::vector<SeriesPainter::WordsPlace> SeriesPainter::places_beside(CanvasPoint point, double width) const {
  constexpr double kAside = 5.0, kRise = 9.0, kFall = 3.0;
  constexpr double kRing = 14.0, kWider = 1.3;
  constexpr int kRings = 8, kDirections = 16;
  std::vector<WordsPlace> places;
  const auto add = [&](CanvasPoint at, TextAnchor anchor, double cost) {
    const double start = anchor == TextAnchor::end ? at.x - width : at.x;
    places.push_back({at, anchor, {start, start + width, at.y - kRise, at.y + kFall}, cost});
  };
  for (const bool left : {false, true}) {
    for (const bool below : {false, true}) {
      add({point.x + (left ? -kAside : kAside), point.y + (below ? kAside + kRise : -kAside)},
          left ? TextAnchor::end : TextAnchor::start, static_cast<double>(places.size()));
    }
  }
  for (int ring = 1; ring <= kRings; ++ring) {
    for (int i = 0; i < kDirections; ++i) {
      const double t = std::numbers::pi * (0.25 + 2.0 * i / kDirections), away = kRing * ring;
      const CanvasPoint middle{point.x + kWider * away * std::cos(t), point.y - away * std::sin(t)};
      add({middle.x - 0.5 * width, middle.y + 0.5 * (kRise - kFall)}, TextAnchor::start, 10.0 * ring);
    }
  }
  return places;
}

SeriesPainter::WordsPlace SeriesPainter::beside(CanvasPoint point, double width) const {
  constexpr double kOnMarker = 25.0, kOnBar = 12.0, kLeadsOverWords = 15.0;
  constexpr std::size_t kMostWords = 100;
  const std::vector<WordsPlace> places = places_beside(point, width);
  if (!cells_.empty() || words_.size() > kMostWords) return places.front();
  const auto overlap = [](const CanvasBox& a, const CanvasBox& b) {
    return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  };
  const auto count = [&](const std::vector<CanvasBox>& boxes, const CanvasBox& box) {
    return static_cast<double>(
        std::ranges::count_if(boxes, [&](const CanvasBox& other) { return overlap(box, other); }));
  };
  const WordsPlace* best = nullptr;
  double least = 0.0;
  for (const WordsPlace& place : places) {
    const CanvasBox& box = place.box;
    const bool usual = &place == places.data();  // also where it reaches over the frame
    const bool inside =
        is_inside({box.left, box.top}, layout_.box) && is_inside({box.right, box.bottom}, layout_.box);
    if (best != nullptr && place.cost >= least) continue;
    if (!(inside || usual) || count(words_, box) > 0.0) continue;
    double cost = place.cost + kOnMarker * count(markers_, box) + kOnBar * count(bars_, box);
    const CanvasPath lead = lead_to(place, point);
    cost += kLeadsOverWords * static_cast<double>(std::ranges::count_if(words_, [&](const CanvasBox& other) {
              return !clip_line(lead, other).empty();
            }));
    if (best != nullptr && cost >= least) continue;
    best = &place;
    least = cost;
  }
  return best == nullptr ? places.front() : *best;
}

CanvasPath SeriesPainter::lead_to(const WordsPlace& place, CanvasPoint point) {
  constexpr double kNear = 12.0;
  const CanvasPoint end{std::clamp(point.x, place.box.left, place.box.right),
                        std::clamp(point.y, place.box.top, place.box.bottom)};
  return std::hypot(end.x - point.x, end.y - point.y) < kNear ? CanvasPath{} : CanvasPath{point, end};
}

// On a cell of a heat map in the one of black and white that can be read there.
void SeriesPainter::words(const Series& series) {
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const CanvasPoint place{scale_.x(series.x[i]), scale_.y(series.y[i])};
    if (!is_inside(place, layout_.box)) continue;
    const auto cell = std::ranges::find_if(cells_, [&](const Cell& c) { return is_inside(place, c.box); });
    const std::uint32_t rgb = cell == cells_.end() ? style_of(series.role).rgb
                              : is_dark(cell->rgb) ? kLightWords
                                                   : kDarkWords;
    const WordsPlace beside_it = beside(place, text_width(series.texts[i]));
    if (const CanvasPath lead = lead_to(beside_it, place); !lead.empty())
      canvas_.stroke({&lead, 1}, {.rgb = rgb, .width = 0.6});
    canvas_.write(series.texts[i], beside_it.at, {.anchor = beside_it.anchor, .rgb = rgb});
    words_.push_back(beside_it.box);
    has_painted_ = true;
  }
}

// Neighbours of one colour in a row are one area. Each reaches a pixel under the next ones to the right and
// above, so that no light shows between them.
void SeriesPainter::cells(const Series& series) {
  constexpr double kUnder = 1.0;
  const std::vector<double> x_edges = cell_edges(series.x, layout_.x.log);
  const std::vector<double> y_edges = cell_edges(series.y, layout_.y.log);
  const auto colour_at = [&](std::size_t i, std::size_t j) {
    const double value = series.cells(static_cast<Index>(i), static_cast<Index>(j));
    return colour_of(share_of_axis(layout_.colour, value), layout_.colour_scale);
  };
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    for (std::size_t j = 0; j < series.x.size();) {
      const std::uint32_t colour = colour_at(i, j);
      const double left = scale_.x(x_edges[j]);
      while (++j < series.x.size() && colour_at(i, j) == colour) {
      }
      const CanvasBox run{left, scale_.x(x_edges[j]) + kUnder, scale_.y(y_edges[i + 1]) - kUnder,
                          scale_.y(y_edges[i])};
      const CanvasPath seen = clip_area(rectangle_path(run), layout_.box);
      if (seen.size() < 3) continue;
      canvas_.fill({&seen, 1}, {colour});
      cells_.push_back({run, colour});
      has_painted_ = true;
    }
  }
}

}  // namespace credence::internal
