#include "analysis/laws/correlation/coarse_series.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace credence::internal {
namespace {

CoarseSeries counted(std::size_t rows) {
  CoarseSeries series;
  for (std::size_t k = 0; k < rows; ++k) series.add(static_cast<double>(k));
  return series;
}

TEST(CoarseSeries, KeepsAShortSeriesAsItIs) {
  const CoarseSeries series = counted(CoarseSeries::kMost - 1);
  EXPECT_EQ(series.rows_per_value(), 1);
  ASSERT_EQ(series.averages().size(), CoarseSeries::kMost - 1);
  EXPECT_EQ(series.averages().back(), static_cast<double>(CoarseSeries::kMost - 2));
}

TEST(CoarseSeries, OfALongOneKeepsAveragesOfEqualLength) {
  const std::size_t rows = 5 * CoarseSeries::kMost + 3;
  const CoarseSeries series = counted(rows);
  const std::int64_t each = series.rows_per_value();
  EXPECT_EQ(each, 8);
  ASSERT_EQ(series.averages().size(), rows / 8);
  for (std::size_t i = 0; i < series.averages().size(); ++i)
    ASSERT_EQ(series.averages()[i], 8.0 * static_cast<double>(i) + 3.5);
}

TEST(CoarseSeries, SeveralAreMadeAlike) {
  const std::vector<CoarseSeries> series = {counted(CoarseSeries::kMost), counted(9)};
  const auto averages = averages_alike(series);
  ASSERT_EQ(averages.size(), 2U);
  EXPECT_EQ(averages[0].size(), CoarseSeries::kMost / 2);
  EXPECT_EQ(averages[1], (std::vector<double>{0.5, 2.5, 4.5, 6.5}));
  EXPECT_TRUE(averages_alike({}).empty());
}

TEST(CoarseSeries, RefusesWhatIsNone) {
  EXPECT_EQ(CoarseSeries({1.0, 2.0}, 4).averages().size(), 2U);
  EXPECT_THROW(CoarseSeries({1.0}, 3), std::invalid_argument);
  EXPECT_THROW(CoarseSeries({1.0}, 0), std::invalid_argument);
  EXPECT_THROW(CoarseSeries(std::vector<double>(CoarseSeries::kMost + 1), 1), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
