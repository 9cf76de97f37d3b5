#include "reports/figures/figure_decimation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace credence::internal {
namespace {

// A noisy curve of 100000 points over 500 pixels with one spike in each direction.
CanvasPath spiky_curve() {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  CanvasPath curve;
  for (int i = 0; i < 100000; ++i) curve.push_back({i * 0.005, 50.0 + 5.0 * normal(generator)});
  curve[12345].y = 175.0;
  curve[54321].y = -60.0;
  return curve;
}

bool has(const CanvasPath& path, const CanvasPoint& point) {
  return std::find(path.begin(), path.end(), point) != path.end();
}

bool is_forward(const CanvasPath& path) { return std::ranges::is_sorted(path, {}, &CanvasPoint::x); }

// The largest distance of a point from the polyline.
double distance_to(const CanvasPoint& p, const CanvasPath& line) {
  double nearest = 1e9;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const CanvasPoint a = line[i - 1];
    const double dx = line[i].x - a.x;
    const double dy = line[i].y - a.y;
    const double squared = dx * dx + dy * dy;
    const double t =
        squared == 0.0 ? 0.0 : std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / squared, 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy));
  }
  return nearest;
}

TEST(Decimation, ColumnsKeepExtremesAndEnds) {
  const CanvasPath curve = spiky_curve();
  const CanvasPath kept = thin_columns(curve);
  EXPECT_LE(kept.size(), 4u * 500u);
  EXPECT_TRUE(has(kept, curve[12345]) && has(kept, curve[54321]));
  EXPECT_TRUE(has(kept, curve.front()) && has(kept, curve.back()));
  EXPECT_TRUE(is_forward(kept));
}

// In every pixel column the curve covers the same heights before and after.
TEST(Decimation, EveryColumnKeepsItsHeight) {
  const CanvasPath curve = spiky_curve();
  const auto heights = [](const CanvasPath& path) {
    std::vector<std::pair<double, double>> columns(500, {1e9, -1e9});
    for (const CanvasPoint& point : path) {
      auto& [low, high] = columns[static_cast<std::size_t>(point.x)];
      low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
    return columns;
  };
  EXPECT_EQ(heights(thin_columns(curve)), heights(curve));
}

TEST(Decimation, CloudsKeepExtremesAndOnePointForEachPixel) {
  const CanvasPath cloud = spiky_curve();
  const CanvasPath kept = thin_cloud(cloud);
  EXPECT_LT(kept.size(), cloud.size() / 2);
  EXPECT_TRUE(has(kept, cloud[12345]) && has(kept, cloud[54321]));
}

TEST(Decimation, PathsStayWithinAPixel) {
  CanvasPath circle;
  for (int i = 0; i <= 50000; ++i)
    circle.push_back({250 + 200 * std::cos(i * 1e-3), 100 + 75 * std::sin(i * 1e-3)});
  const CanvasPath kept = thin_distances(circle);
  EXPECT_LT(kept.size(), circle.size() / 2);
  EXPECT_TRUE(has(kept, circle.front()) && has(kept, circle.back()));
  EXPECT_TRUE(has(kept, *std::ranges::max_element(circle, {}, &CanvasPoint::y)));
  for (std::size_t i = 0; i < circle.size(); i += 97) EXPECT_LT(distance_to(circle[i], kept), 0.5);
}

TEST(Straighten, KeepsTheEndsOfAStraightLineAndTheCornersOfAnother) {
  CanvasPath line;
  for (int i = 0; i <= 1000; ++i) line.push_back({0.4 * i, 7.0 + 0.1 * i});
  EXPECT_EQ(straighten(line, 0.05), (CanvasPath{line.front(), line.back()}));
  const CanvasPath corners{{0, 0}, {5, 0}, {10, 0}, {10, 8}, {10, 9}, {20, 9}};
  EXPECT_EQ(straighten(corners, 0.05), (CanvasPath{{0, 0}, {10, 0}, {10, 9}, {20, 9}}));
}

TEST(Straighten, NoPointLeavesTheTolerance) {
  std::mt19937_64 generator(2);
  std::normal_distribution<double> normal;
  for (const double roughness : {0.0, 0.01, 0.1, 1.0}) {
    CanvasPath curve;
    for (int i = 0; i < 1500; ++i) {
      curve.push_back({0.2 * i, 40.0 * std::sin(0.01 * i) + roughness * normal(generator)});
    }
    const CanvasPath kept = straighten(curve, 0.05);
    EXPECT_EQ(kept.front(), curve.front());
    EXPECT_EQ(kept.back(), curve.back());
    // Behind an end of the line by the tolerance, and beside it by the tolerance.
    for (const CanvasPoint& point : curve) EXPECT_LT(distance_to(point, kept), 0.05 * std::sqrt(2.0) + 1e-9);
    EXPECT_LT(kept.size(), roughness == 0.0 ? 120u : 1501u);
  }
}

TEST(Straighten, TurningBackIsSeen) {
  const CanvasPath back_and_forth{{0, 0}, {10, 0}, {3, 0}, {12, 0}, {-5, 0}, {1, 0}};
  const CanvasPath kept = straighten(back_and_forth, 0.05);
  for (const CanvasPoint& turn : back_and_forth) EXPECT_TRUE(has(kept, turn)) << turn.x;
}

TEST(Decimation, NothingStaysNothing) {
  EXPECT_TRUE(thin_columns({}).empty());
  EXPECT_TRUE(thin_distances({}).empty());
  EXPECT_TRUE(thin_cloud({}).empty());
  EXPECT_TRUE(straighten({}, 0.05).empty());
  EXPECT_EQ(straighten({{1, 2}}, 0.05).size(), 1u);
}

}  // namespace
}  // namespace credence::internal
