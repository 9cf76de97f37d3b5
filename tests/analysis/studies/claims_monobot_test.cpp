#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "analysis/studies/claims.h"

namespace credence::internal {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

/// By id; made once, as it takes a while.
const std::map<std::string, Claim>& claims_by_id() {
  static const std::map<std::string, Claim> all = [] {
    std::map<std::string, Claim> claims;
    for (const Claim& claim : monobot_claims()) {
      EXPECT_TRUE(claims.emplace(claim.id, claim).second) << claim.id;
    }
    return claims;
  }();
  return all;
}

std::string measured_of(const std::string& id) { return claims_by_id().at(id).measured; }
std::string long_run_of(const std::string& id) { return claims_by_id().at(id).long_run; }

TEST(MonobotClaims, ComeOutAsTheTheorySays) {
  // theory, sections 3 to 6.
  const std::map<std::string, ClaimVerdict> expected = {
      {"unit-eigenvalue", ClaimVerdict::holds},    {"bounded-error", ClaimVerdict::holds},
      {"psd-limit", ClaimVerdict::holds},          {"controllability-rank", ClaimVerdict::holds},
      {"observability-rank", ClaimVerdict::holds}, {"gains-die-out", ClaimVerdict::holds},
      {"full-unbounded", ClaimVerdict::holds},     {"map-bounded", ClaimVerdict::conditional},
      {"one-landmark-map", ClaimVerdict::holds},   {"suboptimal-variance", ClaimVerdict::holds},
      {"rank-condition", ClaimVerdict::fails},     {"anchored-bounded", ClaimVerdict::holds}};
  EXPECT_EQ(claims_by_id().size(), expected.size());
  for (const auto& [id, claim] : claims_by_id()) {
    ASSERT_TRUE(expected.contains(id)) << id;
    EXPECT_EQ(claim.verdict, expected.at(id)) << id << ": " << claim.measured << "; " << claim.long_run;
    EXPECT_FALSE(claim.source.empty() || claim.statement.empty() || claim.measured.empty()) << id;
  }
}

// The rows of theory, section 6, after step 100.
TEST(MonobotClaims, CarryTheNumbersOfTheTheory) {
  EXPECT_THAT(measured_of("map-bounded"), HasSubstr("prior 1.872825 m²"));
  EXPECT_THAT(measured_of("map-bounded"), HasSubstr("0.437066"));
  EXPECT_THAT(measured_of("gains-die-out"), HasSubstr("0.004995"));
  EXPECT_THAT(measured_of("full-unbounded"), HasSubstr("12.7056 m²"));
  EXPECT_THAT(measured_of("suboptimal-variance"), HasSubstr("0.390951 m² (optimal 0.347744)"));
  EXPECT_THAT(measured_of("suboptimal-variance"), HasSubstr("of the vehicle 0.383847 m² (0.383847)"));
  EXPECT_THAT(measured_of("suboptimal-variance"), HasSubstr("E[NEES] 2.8882 of 3"));
  EXPECT_THAT(measured_of("anchored-bounded"), HasSubstr("0.089443 m²"));
  EXPECT_THAT(measured_of("anchored-bounded"), HasSubstr("(5.957737 m² without anchor)"));
}

// With one landmark s is that of the difference of two states, whose variance follows d⁻ = d + Q,
// d = d⁻ R/(d⁻ + R): R/s tends to the inverse of the golden ratio's square.
TEST(MonobotClaims, TheSecondEigenvalueIsThatOfTheDifference) {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  EXPECT_NEAR(1.0 / (golden * golden), 0.381966011, 1e-9);
  EXPECT_THAT(measured_of("unit-eigenvalue"),
              HasSubstr("eigenvalues 1.000000000 and 0.381966011, R/s = 0.381966011"));
}

// All differences of landmarks are learnt. Of the place of the whole, what the prior says of two landmarks
// and, by way of the measurements, of the vehicle: (2/c + 1/(c + p))⁻¹ from P0 = c I before the first update,
// p the limit of the variance of the vehicle in the map, by measurements of R/2; before an update it is p +
// Q.
TEST(MonobotClaims, TheLimitIsWhatThePriorSaysOfThePlaceOfTheWhole) {
  constexpr double kProcess = 0.1, kHalfR = 0.05;
  const double before = 0.5 * kProcess * (1.0 + std::sqrt(1.0 + 4.0 * kHalfR / kProcess));
  const double p = before * kHalfR / (before + kHalfR);
  EXPECT_NEAR(p + kProcess, before, 1e-15);
  const auto in_words = [&](double c) {
    return fmt::format("{:.6f} m² from P0 = ", 3.0 / (2.0 / c + 1.0 / (c + p)) + before);
  };
  EXPECT_THAT(measured_of("psd-limit"), HasSubstr(in_words(1.0) + "I"));
  EXPECT_THAT(measured_of("psd-limit"), HasSubstr(in_words(4.0) + "4 I"));
}

TEST(MonobotClaims, RanksAreThoseOfEveryMap) {
  EXPECT_EQ(measured_of("controllability-rank"),
            "1 landmark: 1, 2 landmarks: 1, 5 landmarks: 1, 12 landmarks: 1");
  EXPECT_EQ(measured_of("observability-rank"),
            "n = 2: 1 and 2; n = 3: 2 and 3; n = 6: 5 and 6; n = 13: 12 and 13");
}

// rank ΔP ≤ rank O is necessary (theory, section 5): where (22) says unbounded, P grows.
TEST(MonobotClaims, TheExactConditionErrsInNoCellAndThePapersOnOneSideAlone) {
  EXPECT_THAT(measured_of("rank-condition"), HasSubstr("errs in 0"));
  EXPECT_THAT(measured_of("rank-condition"), HasSubstr("unbounded where it does not in 0;"));
}

// Growth a step of the prior, Q, and of the posterior, Q/(N + 1): theory, section 5.
TEST(MonobotClaims, FarBeyondThePapersStepsTheNumbersSettle) {
  EXPECT_THAT(long_run_of("full-unbounded"),
              ContainsRegex("N = 1: 0\\.099[89][0-9] and 0\\.049[89][0-9] .*N = 2: 0\\.099[89][0-9] and "
                            "0\\.033[23][0-9] .*N = 3: 0\\.099[89][0-9] and 0\\.0249[0-9]"));
  EXPECT_THAT(long_run_of("map-bounded"), HasSubstr("1.872825 m² and 0.437066 at step 4000"));
  EXPECT_THAT(long_run_of("gains-die-out"), HasSubstr("0.000125 at step 4000")) << "1/(N k)";
  EXPECT_TRUE(long_run_of("controllability-rank").empty()) << "nothing changes";
}

TEST(ClaimVerdict, HasItsWords) {
  EXPECT_EQ(to_string(ClaimVerdict::holds), "holds");
  EXPECT_EQ(to_string(ClaimVerdict::conditional), "conditional");
  EXPECT_EQ(to_string(ClaimVerdict::fails), "fails");
  EXPECT_EQ(to_string(ClaimVerdict::not_measured), "not measured");
}

}  // namespace
}  // namespace credence::internal
