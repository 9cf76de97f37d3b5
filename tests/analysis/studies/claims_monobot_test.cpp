#include "analysis/studies/claims.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

TEST(Claims, OfTheMonobotComeOutAsTheTheorySays) {
  // theory, sections 3 to 6.
  const std::map<std::string, ClaimVerdict> expected = {
      {"unit-eigenvalue", ClaimVerdict::holds},    {"bounded-error", ClaimVerdict::holds},
      {"psd-limit", ClaimVerdict::holds},          {"controllability-rank", ClaimVerdict::holds},
      {"observability-rank", ClaimVerdict::holds}, {"gains-die-out", ClaimVerdict::holds},
      {"full-unbounded", ClaimVerdict::holds},     {"map-bounded", ClaimVerdict::conditional},
      {"one-landmark-map", ClaimVerdict::holds},   {"suboptimal-variance", ClaimVerdict::holds},
      {"rank-condition", ClaimVerdict::fails},     {"anchored-bounded", ClaimVerdict::holds}};
  std::set<std::string> seen;
  for (const Claim& claim : monobot_claims()) {
    ASSERT_TRUE(expected.contains(claim.id)) << claim.id;
    EXPECT_EQ(claim.verdict, expected.at(claim.id))
        << claim.id << ": " << claim.measured << "; " << claim.long_run;
    EXPECT_TRUE(seen.insert(claim.id).second) << claim.id;
    EXPECT_FALSE(claim.source.empty() || claim.statement.empty() || claim.measured.empty()) << claim.id;
  }
  EXPECT_EQ(seen.size(), expected.size());
}

TEST(Claims, OfThePlaneComeOutAsTheTheorySays) {
  // theory, section 5.
  const std::map<std::string, ClaimVerdict> expected = {{"planar-controllability", ClaimVerdict::holds},
                                                        {"one-beacon", ClaimVerdict::fails},
                                                        {"planar-full-unbounded", ClaimVerdict::holds},
                                                        {"planar-map-bounded", ClaimVerdict::conditional}};
  const std::vector<Claim> claims = planar_claims();
  EXPECT_EQ(claims.size(), expected.size());
  for (const Claim& claim : claims) {
    ASSERT_TRUE(expected.contains(claim.id)) << claim.id;
    EXPECT_EQ(claim.verdict, expected.at(claim.id))
        << claim.id << ": " << claim.measured << "; " << claim.long_run;
  }
}

TEST(Claims, CarryTheirNumbers) {
  std::map<std::string, std::string> measured;
  for (const Claim& claim : monobot_claims()) measured[claim.id] = claim.measured;
  // The last row of theory, section 6.
  EXPECT_THAT(measured["map-bounded"], HasSubstr("1.872825"));
  EXPECT_THAT(measured["map-bounded"], HasSubstr("0.437066"));
  EXPECT_THAT(measured["rank-condition"], HasSubstr("errs in 0"));
}

/// Steps that take N^exponent, with a factor of `scatter` up and down in turn.
std::vector<FilterTime> times_of(double map_exponent, double scatter) {
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

TEST(Claims, OnTimeFollowTheIntervalOfTheExponent) {
  EXPECT_EQ(linear_time_claim(times_of(1.0, 1.02)).verdict, ClaimVerdict::holds);
  EXPECT_THAT(linear_time_claim(times_of(1.0, 1.02)).measured, HasSubstr("block diagonal map N^1.0"));
  EXPECT_EQ(linear_time_claim(times_of(2.0, 1.02)).verdict, ClaimVerdict::fails);
  const Claim busy = linear_time_claim(times_of(1.3, 2.0));
  EXPECT_EQ(busy.verdict, ClaimVerdict::not_measured);
  EXPECT_THAT(busy.measured, HasSubstr("less busy"));
  EXPECT_EQ(linear_time_claim({}).verdict, ClaimVerdict::not_measured);
}

}  // namespace
}  // namespace credence::internal
