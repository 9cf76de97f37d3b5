#include "reports/figures/figure_marker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/reports/figures/recording_canvas.h"

namespace credence::internal {
namespace {

struct PaintedMarker {
  std::vector<RecordingCanvas::Line> lines;
  std::vector<RecordingCanvas::Area> areas;
};

PaintedMarker painted_marker(MarkerShape shape, double weight = 1.0,
                             const CanvasPath& places = {{10.0, 20.0}}) {
  Series series;
  series.role = ColourRole::first;
  series.marker = shape;
  series.weight = weight;
  RecordingCanvas canvas;
  paint_markers(series, places, canvas);
  return {canvas.lines, canvas.areas};
}

/// Twice the signed area: half the sum of cross products along the outline.
double marker_area(const CanvasPath& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const CanvasPoint &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2.0;
}

CanvasPoint middle_of(const CanvasPath& path) {
  CanvasPoint sum{0.0, 0.0};
  for (const CanvasPoint& p : path) {
    sum.x += p.x / static_cast<double>(path.size());
    sum.y += p.y / static_cast<double>(path.size());
  }
  return sum;
}

TEST(FigureMarker, OnAHeatMapALightRimIsBelowIt) {
  Series series;
  series.role = ColourRole::truth;
  RecordingCanvas canvas;
  paint_markers(series, {{10.0, 20.0}}, canvas, true);
  ASSERT_EQ(canvas.lines.size() % 2, 0U);
  const std::size_t half = canvas.lines.size() / 2;
  EXPECT_EQ(canvas.lines.front().pen.rgb, 0xffffffU);
  EXPECT_EQ(canvas.lines.back().pen.rgb, 0x000000U);
  EXPECT_GT(canvas.lines.front().pen.width, canvas.lines[half].pen.width + 1.0);
}

TEST(FigureMarker, EveryShapeIsAboutItsPlace) {
  for (const MarkerShape shape : {MarkerShape::dot, MarkerShape::plus, MarkerShape::cross,
                                  MarkerShape::square, MarkerShape::triangle, MarkerShape::diamond}) {
    const PaintedMarker canvas = painted_marker(shape);
    std::vector<CanvasPath> paths;
    for (const auto& line : canvas.lines) paths.push_back(line.path);
    for (const auto& area : canvas.areas) paths.push_back(area.outline);
    ASSERT_FALSE(paths.empty()) << static_cast<int>(shape);
    for (const CanvasPath& path : paths) {
      EXPECT_NEAR(middle_of(path).x, 10.0, 1e-12);
      EXPECT_NEAR(middle_of(path).y, 20.0, 0.05) << static_cast<int>(shape);
    }
  }
}

TEST(FigureMarker, AreasAreOfLikeSize) {
  // So that no curve looks heavier than another: within a factor of two of the square.
  const auto area = [](MarkerShape shape) { return marker_area(painted_marker(shape).areas.at(0).outline); };
  const double square = area(MarkerShape::square);
  for (const MarkerShape shape : {MarkerShape::triangle, MarkerShape::diamond}) {
    EXPECT_LT(area(shape), 2.0 * square);
    EXPECT_GT(area(shape), square / 2.0);
  }
  EXPECT_NEAR(marker_area(painted_marker(MarkerShape::square, 2.0).areas.at(0).outline), 4.0 * square, 1e-9)
      << "weight is of lengths";
}

TEST(FigureMarker, CrossesAreTwoLinesThatMeetAtThePlace) {
  for (const MarkerShape shape : {MarkerShape::plus, MarkerShape::cross}) {
    const PaintedMarker canvas = painted_marker(shape);
    ASSERT_EQ(canvas.lines.size(), 2U);
    EXPECT_TRUE(canvas.areas.empty());
    const CanvasPath &a = canvas.lines[0].path, &b = canvas.lines[1].path;
    // At right angles.
    EXPECT_NEAR((a[1].x - a[0].x) * (b[1].x - b[0].x) + (a[1].y - a[0].y) * (b[1].y - b[0].y), 0.0, 1e-12);
  }
}

TEST(FigureMarker, ThatOfTheRoleIsTakenWhereNoneIsAskedFor) {
  const PaintedMarker by_role = painted_marker(MarkerShape::by_role),
                      own = painted_marker(style_of(ColourRole::first).marker);
  ASSERT_EQ(by_role.lines.size(), own.lines.size());
  EXPECT_EQ(by_role.lines.at(0).pen.width, own.lines.at(0).pen.width);
  EXPECT_TRUE(by_role.lines.at(0).pen.dots);
  EXPECT_EQ(by_role.lines.at(0).pen.rgb, style_of(ColourRole::first).rgb);
}

TEST(FigureMarker, StandsAtEveryPlaceAndNowhereElse) {
  EXPECT_EQ(painted_marker(MarkerShape::square, 1.0, {{0, 0}, {5, 5}, {9, 1}}).areas.size(), 3U);
  EXPECT_TRUE(painted_marker(MarkerShape::square, 1.0, {}).areas.empty());
}

TEST(FigureMarker, ABoxHasItsCornersInOrder) {
  EXPECT_NEAR(marker_area(rectangle_path({.left = 1.0, .right = 4.0, .top = 2.0, .bottom = 8.0})), 18.0,
              1e-12);
}

}  // namespace
}  // namespace credence::internal
