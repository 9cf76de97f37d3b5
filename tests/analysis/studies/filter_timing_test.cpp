#include "analysis/studies/filter_timing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

FilterTime time_of(TimedFilter filter, Index landmarks, double seconds, Index observed = 1) {
  return {filter, landmarks, observed, summarise_times({seconds}), {}};
}

TEST(FilterTiming, FitsOnlyWhereTheMapOutweighsTheRest) {
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
TEST(FilterTiming, FindsWhereTheLinearFilterOvertakes) {
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

TEST(FilterTiming, TimesEveryFilterAtEverySizeItBears) {
  const FilterTimingPlan plan{
      .landmarks = {5, 20}, .observed = {1, 10}, .timing = {.repetitions = 2, .seconds = 1e-5}};
  const TimingResult result = time_filters(plan);
  EXPECT_TRUE(result.complete);
  // Ten cannot be observed of five.
  ASSERT_EQ(result.filters.size(), 12U);
  for (const FilterTime& time : result.filters) {
    EXPECT_GT(time.step.median, 0.0);
    if (time.bytes) {
      EXPECT_GT(*time.bytes, 0.0);
    }
  }
  for (const MeasuredTime& time :
       {result.monte_carlo.step, result.monte_carlo.normal, result.monte_carlo.reference_step}) {
    EXPECT_GT(time.median, 0.0);
  }
  EXPECT_EQ(result.scaling.front().threads, 1);
}

TEST(FilterTiming, RefusesAPlanOfNothing) {
  EXPECT_THROW(time_filters({.landmarks = {}}), std::invalid_argument);
  EXPECT_THROW(time_filters({.landmarks = {0}}), std::invalid_argument);
  EXPECT_THROW(time_filters({.landmarks = {5}, .observed = {10}}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
