#include "reports/figures/figure_marker.h"

namespace credence::internal {
namespace {

// Adds what a marker of "radius" r at p consists of: lines, the outline of an area, or a point.
void add_marker(MarkerShape shape, const CanvasPoint& p, double r, std::vector<CanvasPath>& paths) {
  switch (shape) {
    case MarkerShape::plus:
      paths.push_back({{p.x - r, p.y}, {p.x + r, p.y}});
      paths.push_back({{p.x, p.y - r}, {p.x, p.y + r}});
      return;
    case MarkerShape::cross:
      paths.push_back({{p.x - r, p.y - r}, {p.x + r, p.y + r}});
      paths.push_back({{p.x - r, p.y + r}, {p.x + r, p.y - r}});
      return;
    case MarkerShape::square: paths.push_back(rectangle_path({p.x - r, p.x + r, p.y - r, p.y + r})); return;
    case MarkerShape::triangle:
      paths.push_back(
          {{p.x, p.y - 1.33 * r}, {p.x - 1.33 * r, p.y + 0.67 * r}, {p.x + 1.33 * r, p.y + 0.67 * r}});
      return;
    case MarkerShape::diamond:
      paths.push_back(
          {{p.x, p.y - 1.4 * r}, {p.x - 1.4 * r, p.y}, {p.x, p.y + 1.4 * r}, {p.x + 1.4 * r, p.y}});
      return;
    case MarkerShape::dot:
    case MarkerShape::by_role: paths.push_back({p});
  }
}

}  // namespace

CanvasPath rectangle_path(const CanvasBox& box) {
  return {{box.left, box.top}, {box.right, box.top}, {box.right, box.bottom}, {box.left, box.bottom}};
}

void paint_markers(const Series& series, const CanvasPath& places, Canvas& canvas, bool rim) {
  constexpr double kDot = 1.9;
  constexpr double kCross = 3.6;  // without area, hence larger
  constexpr double kArea = 2.7;
  const RoleStyle style = style_of(series.role);
  const MarkerShape shape = series.marker == MarkerShape::by_role ? style.marker : series.marker;
  const bool dot = shape == MarkerShape::dot;
  const bool cross = shape == MarkerShape::plus || shape == MarkerShape::cross;
  const double radius = series.weight * (dot ? kDot : cross ? kCross : kArea);
  std::vector<CanvasPath> paths;
  for (const CanvasPoint& place : places) add_marker(shape, place, radius, paths);
  constexpr double kStroke = 1.2, kRim = 1.1;  // on each side
  constexpr std::uint32_t kLight = 0xffffff;
  if (rim) {
    const double width = dot ? 2.0 * radius : cross ? kStroke : 0.0;
    canvas.stroke(paths, {.rgb = kLight, .width = width + 2.0 * kRim, .dots = dot});
  }
  if (dot) {
    canvas.stroke(paths, {.rgb = style.rgb, .width = 2.0 * radius, .dots = true});
  } else if (cross) {
    canvas.stroke(paths, {.rgb = style.rgb, .width = kStroke});
  } else {
    canvas.fill(paths, {style.rgb});
  }
}

}  // namespace credence::internal
