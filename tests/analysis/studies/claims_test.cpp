#include "analysis/studies/claims.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace credence {
namespace {

TEST(Claims, OfTheMonobotComeOutAsTheTheorySays) {
  // theory, sections 3 to 6.
  const std::map<std::string, ClaimVerdict> expected = {
      {"unit-eigenvalue", ClaimVerdict::holds},    {"bounded-error", ClaimVerdict::holds},
      {"psd-limit", ClaimVerdict::holds},          {"controllability-rank", ClaimVerdict::holds},
      {"observability-rank", ClaimVerdict::holds}, {"gains-die-out", ClaimVerdict::holds},
      {"full-unbounded", ClaimVerdict::holds},     {"map-bounded", ClaimVerdict::conditional},
      {"one-landmark-map", ClaimVerdict::holds},   {"suboptimal-variance", ClaimVerdict::holds},
      {"rank-condition", ClaimVerdict::fails},     {"anchored-bounded", ClaimVerdict::holds},
      {"linear-time", ClaimVerdict::not_measured}};
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
  for (const Claim& claim : monobot_claims()) {
    if (claim.id == "map-bounded") {
      // The last row of theory, section 6.
      EXPECT_NE(claim.measured.find("1.872825"), std::string::npos) << claim.measured;
      EXPECT_NE(claim.measured.find("0.437066"), std::string::npos) << claim.measured;
    }
    if (claim.id == "rank-condition") {
      EXPECT_NE(claim.measured.find("errs in 0"), std::string::npos) << claim.measured;
    }
  }
}

}  // namespace
}  // namespace credence
