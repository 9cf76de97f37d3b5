#include "reports/figures/panel_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

PanelLayout layout_of(AxisRange x, AxisRange y, bool log) {
  PanelLayout layout;
  layout.box = {100.0, 300.0, 50.0, 150.0};
  layout.x = make_axis(x, log, 5);
  layout.y = make_axis(y, log, 5);
  return layout;
}

TEST(PanelScale, ValuesGrowToTheRightAndUp) {
  const PanelLayout layout = layout_of({0, 10}, {-1, 1}, false);
  const PanelScale scale(layout);
  EXPECT_DOUBLE_EQ(scale.x(0), 100.0);
  EXPECT_DOUBLE_EQ(scale.x(5), 200.0);
  EXPECT_DOUBLE_EQ(scale.y(-1), 150.0);
  EXPECT_DOUBLE_EQ(scale.y(1), 50.0);
}

TEST(PanelScale, DecadesAreEquallyLong) {
  const PanelLayout layout = layout_of({1, 100}, {1e-4, 1}, true);
  const PanelScale scale(layout);
  EXPECT_NEAR(scale.x(10), 200.0, 1e-9);
  EXPECT_NEAR(scale.y(1e-1), 75.0, 1e-9);
  EXPECT_TRUE(std::isnan(scale.x(0)) && std::isnan(scale.y(-3)));
}

TEST(PanelScale, FarAwayIsBounded) {
  const PanelLayout layout = layout_of({0, 1}, {0, 1}, false);
  const PanelScale scale(layout);
  EXPECT_EQ(scale.x(1e308), 1e6);
  EXPECT_EQ(scale.y(1e308), -1e6);
  EXPECT_TRUE(std::isnan(scale.x(kInfinity)));
}

TEST(PanelScale, CurvesBreakWherePointsHaveNoPlace) {
  const PanelLayout linear = layout_of({0, 10}, {0, 10}, false);
  const auto pieces = PanelScale(linear).curves({1, 2, 3, 4, 5, kNaN}, {1, 1, kInfinity, 1, kNaN, 1});
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].size(), 2u);
  EXPECT_EQ(pieces[1], (CanvasPath{{180.0, 140.0}}));
  const PanelLayout log = layout_of({1, 10}, {1, 10}, true);
  EXPECT_EQ(PanelScale(log).curves({1, 2, 3}, {1, 0, 1}).size(), 2u) << "log axes need positive values";
  EXPECT_TRUE(PanelScale(log).curves({-1}, {1}).empty());
  EXPECT_TRUE(PanelScale(log).curves({}, {}).empty());
}

}  // namespace
}  // namespace credence::internal
