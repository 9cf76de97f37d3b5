#include "reports/figures/figure_decimation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace credence {
namespace {

constexpr PixelBox kBox{0.0, 100000.0, -10.0, 30.0, 500, 200};

// A noisy curve with one spike in each direction.
struct SpikyCurve {
  std::vector<double> x, y;
  SpikyCurve() {
    std::mt19937_64 generator(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 100000; ++i) {
      x.push_back(i);
      y.push_back(normal(generator));
    }
    y[12345] = 25.0;
    y[54321] = -8.0;
  }
};

bool has(const std::vector<std::size_t>& kept, std::size_t index) {
  return std::find(kept.begin(), kept.end(), index) != kept.end();
}

TEST(Decimation, ColumnsKeepExtremesAndEnds) {
  const SpikyCurve curve;
  const auto kept = keep_by_column(curve.x, curve.y, kBox);
  EXPECT_LE(kept.size(), 4u * 500u);
  EXPECT_TRUE(has(kept, 12345) && has(kept, 54321));
  EXPECT_TRUE(has(kept, 0) && has(kept, curve.x.size() - 1));
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
}

// In every pixel column the curve covers the same heights before and after.
TEST(Decimation, EveryColumnKeepsItsHeight) {
  const SpikyCurve curve;
  const auto kept = keep_by_column(curve.x, curve.y, kBox);
  std::vector<double> low(500, 1e9);
  std::vector<double> high(500, -1e9);
  for (const std::size_t i : kept) {
    const std::size_t column = i / 200;
    low[column] = std::min(low[column], curve.y[i]);
    high[column] = std::max(high[column], curve.y[i]);
  }
  for (std::size_t column = 0; column < 500; ++column) {
    const auto first = curve.y.begin() + static_cast<std::ptrdiff_t>(200 * column);
    const auto [lowest, highest] = std::minmax_element(first, first + 200);
    EXPECT_EQ(low[column], *lowest);
    EXPECT_EQ(high[column], *highest);
  }
}

TEST(Decimation, CloudsKeepExtremesAndOnePointForEachPixel) {
  const SpikyCurve curve;
  const auto kept = keep_by_pixel(curve.x, curve.y, kBox);
  EXPECT_LT(kept.size(), curve.x.size() / 2);
  EXPECT_TRUE(has(kept, 12345) && has(kept, 54321));
}

TEST(Decimation, PathsStayWithinAPixel) {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i <= 50000; ++i) {
    x.push_back(50000.0 + 40000.0 * std::cos(i * 1e-3));
    y.push_back(10.0 + 15.0 * std::sin(i * 1e-3));
  }
  const auto kept = keep_by_distance(x, y, kBox);
  EXPECT_LT(kept.size(), x.size() / 2);
  EXPECT_TRUE(has(kept, 0) && has(kept, x.size() - 1));
  EXPECT_TRUE(has(kept, static_cast<std::size_t>(std::max_element(y.begin(), y.end()) - y.begin())));
  for (std::size_t k = 1; k < kept.size(); ++k) {
    for (std::size_t i = kept[k - 1] + 1; i < kept[k]; ++i) {
      const double moved =
          std::hypot((x[i] - x[kept[k - 1]]) * 500 / 1e5, (y[i] - y[kept[k - 1]]) * 200 / 40);
      EXPECT_LT(moved, 0.5);
    }
  }
}

TEST(Decimation, BreaksWherePointsAreNotUsable) {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  const auto pieces = finite_pieces({1, 2, 3, 4, 5, nan}, {1, 1, infinity, 1, nan, 1}, false, false);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].x, (std::vector<double>{1, 2}));
  EXPECT_EQ(pieces[1].x, (std::vector<double>{4}));
  EXPECT_EQ(finite_pieces({1, 2, 3}, {1, 0, 1}, false, true).size(), 2u) << "log axes need positive values";
  EXPECT_TRUE(finite_pieces({-1}, {1}, true, false).empty());
  EXPECT_TRUE(finite_pieces({}, {}, false, false).empty());
}

TEST(Decimation, NothingStaysNothing) {
  EXPECT_TRUE(keep_by_column({}, {}, kBox).empty());
  EXPECT_TRUE(keep_by_distance({}, {}, kBox).empty());
  EXPECT_TRUE(keep_by_pixel({}, {}, kBox).empty());
}

}  // namespace
}  // namespace credence
