#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "analysis/studies/claims.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

/// Steps that take N^exponent, with a factor of `scatter` up and down in turn.
std::vector<FilterTime> claim_times(double map_exponent, double scatter) {
  std::vector<FilterTime> times;
  for (const TimedFilter filter : {TimedFilter::full, TimedFilter::map}) {
    const double exponent = filter == TimedFilter::map ? map_exponent : 2.0;
    for (const Index n : {1000, 2000, 4000, 8000}) {
      FilterTime time{.filter = filter, .landmarks = n, .observed = 2, .step = {}, .bytes = {}};
      time.step.median = 1e-8 * std::pow(n, exponent) * (n == 1000 || n == 8000 ? scatter : 1.0);
      times.push_back(time);
    }
  }
  return times;
}

TEST(TimingClaim, FollowsTheIntervalOfTheExponent) {
  EXPECT_EQ(linear_time_claim(claim_times(1.0, 1.02)).verdict, ClaimVerdict::holds);
  EXPECT_EQ(linear_time_claim(claim_times(2.0, 1.02)).verdict, ClaimVerdict::fails);
  const Claim busy = linear_time_claim(claim_times(1.3, 2.0));
  EXPECT_EQ(busy.verdict, ClaimVerdict::not_measured);
  EXPECT_THAT(busy.measured, HasSubstr("less busy"));
}

// A power law without scatter has its exponent, and an interval of no width.
TEST(TimingClaim, SaysTheExponentsOfBothFiltersAndHowFarTheyWereTimed) {
  const Claim claim = linear_time_claim(claim_times(1.25, 1.0));
  EXPECT_EQ(claim.verdict, ClaimVerdict::holds);
  EXPECT_EQ(claim.measured,
            "time of a step with 2 landmarks in view, to N = 8000: block diagonal map N^1.25 (95 % 1.25 … "
            "1.25), full P N^2.00 (95 % 2.00 … 2.00)");
  EXPECT_EQ(linear_time_claim(claim_times(1.45, 1.0)).verdict, ClaimVerdict::holds);
  EXPECT_EQ(linear_time_claim(claim_times(1.55, 1.0)).verdict, ClaimVerdict::fails);
}

TEST(TimingClaim, IsNotMeasuredWithoutAFitOfBothFilters) {
  for (const TimedFilter only : {TimedFilter::full, TimedFilter::map}) {
    std::vector<FilterTime> times = claim_times(1.0, 1.02);
    std::erase_if(times, [&](const FilterTime& time) { return time.filter != only; });
    EXPECT_EQ(linear_time_claim(times).verdict, ClaimVerdict::not_measured);
    EXPECT_EQ(linear_time_claim(times).measured, "too few sizes of the map were timed");
  }
  const Claim none = linear_time_claim({});
  EXPECT_EQ(none.verdict, ClaimVerdict::not_measured);
  EXPECT_EQ(none.id, "linear-time");
}

TEST(TimingClaim, IsNoneWhereTheTimingWasStopped) {
  const std::atomic<bool> stop{true};
  EXPECT_TRUE(timing_claims(&stop).empty());
}

}  // namespace
}  // namespace credence::internal
