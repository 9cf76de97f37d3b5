#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "analysis/studies/filter_timing.h"

namespace credence::internal {
namespace {

FilterTime time_of(TimedFilter filter, Index landmarks, double seconds, Index observed = 1) {
  return {filter, landmarks, observed, summarise_times({seconds}), {}};
}

TEST(FilterTimingFits, FitsOnlyWhereTheMapOutweighsTheRest) {
  std::vector<FilterTime> times;
  for (const Index n : {10, 100, 300, 1000, 2000}) {
    const double square = 1e-10 * static_cast<double>(n * n);
    // A constant below 300 landmarks must not flatten the slope.
    times.push_back(time_of(TimedFilter::full, n, n < 300 ? 1.0 : square));
    times.push_back(time_of(TimedFilter::map, n, 1e-9 * static_cast<double>(n)));
  }
  const std::vector<GrowthFit> fits = fit_growth(times);
  // Two sizes from 1000 on are too few for the O(N) filter.
  ASSERT_EQ(fits.size(), 1U);
  EXPECT_EQ(fits[0].filter, TimedFilter::full);
  EXPECT_EQ(fits[0].points, 3);
  EXPECT_NEAR(fits[0].law.exponent, 2.0, 1e-12);
}

// full 1e-10 N² against map 1e-8 N: equal at N = 100.
TEST(FilterTimingFits, FindsWhereTheLinearFilterOvertakes) {
  std::vector<FilterTime> times;
  for (const Index n : {20, 50, 400, 1000}) {
    const double size = static_cast<double>(n);
    times.push_back(time_of(TimedFilter::full, n, 1e-10 * size * size));
    times.push_back(time_of(TimedFilter::map, n, 1e-8 * size));
    times.push_back(time_of(TimedFilter::full, n, 1.0, 10));
    times.push_back(time_of(TimedFilter::map, n, 0.5, 10));
  }
  const std::vector<Crossover> crossovers = find_crossovers(times);
  ASSERT_EQ(crossovers.size(), 2U);
  ASSERT_TRUE(crossovers[0].landmarks.has_value());
  EXPECT_NEAR(*crossovers[0].landmarks, 100.0, 1e-9);
  EXPECT_FALSE(crossovers[1].landmarks.has_value());
  EXPECT_EQ(crossovers[1].faster_below, TimedFilter::map);
}

// The order in which sizes were measured, and sizes that one of the two lacks, are of no matter.
TEST(FilterTimingFits, TakesTheSizesThatBothHaveByRisingSize) {
  const std::vector<FilterTime> times = {
      time_of(TimedFilter::full, 1000, 4.0), time_of(TimedFilter::map, 10, 2.0),
      time_of(TimedFilter::map, 1000, 2.0),  time_of(TimedFilter::full, 10, 1.0),
      time_of(TimedFilter::full, 100, 1e9),  time_of(TimedFilter::map, 100'000, 200.0)};
  const std::vector<Crossover> crossovers = find_crossovers(times);
  ASSERT_EQ(crossovers.size(), 1U);
  EXPECT_EQ(crossovers[0].observed, 1);
  EXPECT_EQ(crossovers[0].faster_below, TimedFilter::full);
  EXPECT_NEAR(crossovers[0].landmarks.value(), 100.0, 1e-9);  // ratios 1/2 and 2: half way in log N
}

TEST(FilterTimingFits, OneFilterAloneCrossesNothing) {
  EXPECT_TRUE(find_crossovers({}).empty());
  EXPECT_TRUE(fit_growth({}).empty());
  const std::vector<FilterTime> alone = {time_of(TimedFilter::full, 10, 1.0),
                                         time_of(TimedFilter::full, 20, 2.0)};
  EXPECT_TRUE(find_crossovers(alone).empty());
}

// Each number observed has a law of its own, of the filters in their order.
TEST(FilterTimingFits, EveryNumberObservedHasItsLaw) {
  std::vector<FilterTime> times;
  for (const Index n : {20'000, 10'000, 100'000, 1000}) {
    const auto size = static_cast<double>(n);
    for (const Index observed : {10, 1}) {
      times.push_back(time_of(TimedFilter::batch, n,
                              (n < 10'000 ? 9.0 : 1e-7) * size * static_cast<double>(observed), observed));
      times.push_back(time_of(TimedFilter::map, n, 1e-7 * std::pow(size, 1.5), observed));
    }
  }
  const std::vector<GrowthFit> fits = fit_growth(times);
  ASSERT_EQ(fits.size(), 4U);
  EXPECT_EQ(fits[0].filter, TimedFilter::map);
  EXPECT_EQ(fits[0].observed, 1);
  EXPECT_EQ(fits[0].from, 1000);
  EXPECT_EQ(fits[0].points, 4);
  EXPECT_NEAR(fits[0].law.exponent, 1.5, 1e-12);
  EXPECT_EQ(fits[3].filter, TimedFilter::batch);
  EXPECT_EQ(fits[3].observed, 10);
  EXPECT_EQ(fits[3].from, 10'000);
  EXPECT_EQ(fits[3].points, 3);
  EXPECT_NEAR(fits[3].law.exponent, 1.0, 1e-12);
}

}  // namespace
}  // namespace credence::internal
