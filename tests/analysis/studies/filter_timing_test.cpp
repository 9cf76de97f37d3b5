#include "analysis/studies/filter_timing.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

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
