#include "reports/figures/figure_clip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

constexpr CanvasBox kBox{0.0, 10.0, 0.0, 5.0};

double area_of(const CanvasPath& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const CanvasPoint& a = outline[i];
    const CanvasPoint& b = outline[(i + 1) % outline.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * std::abs(twice);
}

double length_of(const std::vector<CanvasPath>& lines) {
  double length = 0.0;
  for (const CanvasPath& line : lines) {
    for (std::size_t i = 1; i < line.size(); ++i) {
      length += std::hypot(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
    }
  }
  return length;
}

TEST(ClipLine, KeepsWhatIsInside) {
  const CanvasPath line{{1, 1}, {2, 4}, {9, 2}};
  EXPECT_EQ(clip_line(line, kBox), std::vector<CanvasPath>{line});
  EXPECT_EQ(clip_line({{3, 3}}, kBox), (std::vector<CanvasPath>{{{3, 3}}})) << "a point";
  EXPECT_TRUE(clip_line({{30, 3}}, kBox).empty());
  EXPECT_TRUE(clip_line({}, kBox).empty());
}

TEST(ClipLine, CutsAtTheBorderAndBreaksOutside) {
  const auto pieces = clip_line({{-5, 2}, {5, 2}, {5, 8}, {8, 8}, {8, 2}}, kBox);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0], (CanvasPath{{0, 2}, {5, 2}, {5, 5}}));
  EXPECT_EQ(pieces[1], (CanvasPath{{8, 5}, {8, 2}}));
}

TEST(ClipLine, SeesALineThatCrossesWithoutAPointInside) {
  EXPECT_EQ(clip_line({{-10, 2}, {20, 2}}, kBox), (std::vector<CanvasPath>{{{0, 2}, {10, 2}}}));
  EXPECT_TRUE(clip_line({{-2, 4}, {4, 10}}, kBox).empty()) << "passes a corner";
  EXPECT_TRUE(clip_line({{0, 6}, {10, 6}}, kBox).empty()) << "beside, parallel";
}

TEST(ClipLine, FarAwayIsNoTrouble) {
  const auto pieces = clip_line({{5, -1e6}, {5, 1e6}}, kBox);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_NEAR(length_of(pieces), 5.0, 1e-8);
}

// The length inside, against counting small steps of random segments.
TEST(ClipLine, LengthAgreesWithSampling) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> x(-5, 15), y(-3, 8);
  for (int i = 0; i < 200; ++i) {
    const CanvasPoint a{x(generator), y(generator)};
    const CanvasPoint b{x(generator), y(generator)};
    constexpr int kSteps = 4000;
    int inside = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double t = (k + 0.5) / kSteps;
      inside += is_inside({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, kBox) ? 1 : 0;
    }
    const double whole = std::hypot(b.x - a.x, b.y - a.y);
    EXPECT_NEAR(length_of(clip_line({a, b}, kBox)), whole * inside / kSteps, 2.0 * whole / kSteps);
  }
}

TEST(ClipArea, CutsAtTheBorder) {
  EXPECT_DOUBLE_EQ(area_of(clip_area({{-5, -5}, {20, -5}, {20, 20}, {-5, 20}}, kBox)), 50.0) << "the box";
  EXPECT_DOUBLE_EQ(area_of(clip_area({{1, 1}, {3, 1}, {3, 2}}, kBox)), 1.0) << "inside";
  EXPECT_DOUBLE_EQ(area_of(clip_area({{8, 1}, {14, 1}, {14, 3}, {8, 3}}, kBox)), 4.0);
  EXPECT_TRUE(clip_area({{11, 1}, {14, 1}, {14, 3}}, kBox).empty());
  EXPECT_TRUE(clip_area({}, kBox).empty());
}

}  // namespace
}  // namespace credence::internal
