#include "analysis/laws/correlation/thinned_series.h"

#include <gtest/gtest.h>

#include <numeric>

namespace credence::internal {
namespace {

std::vector<double> counted_to(std::size_t count) {
  std::vector<double> values(count);
  std::iota(values.begin(), values.end(), 0.0);
  return values;
}

TEST(ThinnedSeries, LeavesAShortOneAsItIs) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{20'000}}) {
    const std::vector<double> values = counted_to(count);
    const ThinnedSeries series = thinned(values);
    EXPECT_EQ(series.values, values);
    EXPECT_EQ(series.rows_per_value, 1.0);
  }
}

TEST(ThinnedSeries, AveragesAsManyAsLeaveTwentyThousandAtMost) {
  for (const auto& [count, group] : {std::pair<std::size_t, std::size_t>{20'001, 2},
                                     {40'000, 2},
                                     {40'001, 3},
                                     {60'000, 3},
                                     {1'000'003, 51}}) {
    const ThinnedSeries series = thinned(counted_to(count));
    EXPECT_EQ(series.rows_per_value, static_cast<double>(group));
    ASSERT_EQ(series.values.size(), count / group);
    EXPECT_LE(series.values.size(), 20'000U);
    // The mean of i group … i group + group − 1.
    const double half = 0.5 * static_cast<double>(group - 1);
    for (std::size_t i = 0; i < series.values.size(); ++i) {
      ASSERT_DOUBLE_EQ(series.values[i], static_cast<double>(i * group) + half) << count;
    }
  }
}

TEST(ThinnedSeries, AreThinnedAlikeByTheLongestOfThem) {
  const ThinnedSeries brief = thinned(counted_to(10), 80'000);
  EXPECT_EQ(brief.rows_per_value, 4.0);
  EXPECT_EQ(brief.values, (std::vector<double>{1.5, 5.5}));
  EXPECT_EQ(thinned(counted_to(30'000), 10).rows_per_value, 2.0) << "at least as its own length asks";
}

}  // namespace
}  // namespace credence::internal
