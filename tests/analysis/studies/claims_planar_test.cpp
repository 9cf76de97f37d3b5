#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "analysis/studies/claims.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

/// Enough to tell growth of a half a per cent a loop from none.
constexpr Index kFewLoops = 8;

// theory, section 5: with six landmarks there are n = 15 states, of which Jacobians at the truth tell n − 3
// without an anchor. What an EKF sees more is spurious.
TEST(PlanarClaims, ComeOutAsTheTheorySaysWithTheRanksThatItNames) {
  const std::map<std::string, ClaimVerdict> expected = {{"planar-controllability", ClaimVerdict::holds},
                                                        {"one-beacon", ClaimVerdict::fails},
                                                        {"planar-full-unbounded", ClaimVerdict::holds},
                                                        {"planar-map-bounded", ClaimVerdict::conditional}};
  const std::vector<Claim> claims = planar_claims(kFewLoops);
  EXPECT_EQ(claims.size(), expected.size());
  std::map<std::string, Claim> by_id;
  for (const Claim& claim : claims) {
    ASSERT_TRUE(expected.contains(claim.id)) << claim.id;
    EXPECT_EQ(claim.verdict, expected.at(claim.id))
        << claim.id << ": " << claim.measured << "; " << claim.long_run;
    by_id[claim.id] = claim;
  }
  EXPECT_THAT(by_id["planar-controllability"].measured, HasSubstr("3 of 15 states"));
  EXPECT_THAT(by_id["one-beacon"].measured, HasSubstr("12 of 15 without anchor"));
  EXPECT_THAT(by_id["planar-full-unbounded"].measured, HasSubstr("over 8 loops"));
  EXPECT_THAT(by_id["planar-map-bounded"].measured, HasSubstr("exact minimal trace bounded"));
}

}  // namespace
}  // namespace credence::internal
