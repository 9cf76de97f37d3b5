#include "analysis/laws/joint/joint_tests.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/laws/joint/multiple_tests.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

constexpr DirectedTest kNoData{Departure::optimistic, std::numeric_limits<double>::quiet_NaN()};

TEST(WeightedHolm, ByHand) {
  // p/w = 0.02, 0.08, 0.03: the order is 0, 2, 1, with the weights 1, then ½, then ¼ remaining.
  const std::vector<double> adjusted =
      weighted_holm(std::array{0.01, 0.02, 0.0075}, std::array{0.5, 0.25, 0.25});
  EXPECT_NEAR(adjusted[0], 0.02, 1e-15);
  EXPECT_NEAR(adjusted[1], 0.02, 1e-15);
  EXPECT_NEAR(adjusted[2], 0.02, 1e-15);
  const std::vector<double> spread = weighted_holm(std::array{0.01, 0.02, 0.05}, std::array{0.5, 0.25, 0.25});
  EXPECT_NEAR(spread[0], 0.02, 1e-15);
  EXPECT_NEAR(spread[1], 0.04, 1e-15);
  EXPECT_NEAR(spread[2], 0.05, 1e-15);
}

TEST(WeightedHolm, EqualWeightsGiveHolm) {
  const std::array p{0.01, 0.04, std::nan(""), 0.03, 0.005, 1.0};
  const std::vector<double> plain = holm(p);
  const std::vector<double> weighted = weighted_holm(p, std::array{3.0, 3.0, -1.0, 3.0, 3.0, 3.0});
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (i == 2) {
      EXPECT_TRUE(std::isnan(weighted[i]));
    } else {
      EXPECT_NEAR(weighted[i], plain[i], 1e-15);
    }
  }
  EXPECT_THROW(weighted_holm(std::array{0.1}, std::array{0.0}), std::invalid_argument);
  EXPECT_THROW(weighted_holm(std::array{0.1}, std::array{1.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(weighted_holm(std::array{1.1}, std::array{1.0}), std::invalid_argument);
}

TEST(JointTests, BothDirectionsAreMixedAndNotTheSmallerOne) {
  const std::array run_means{DirectedTest{Departure::optimistic, 1e-4},
                             DirectedTest{Departure::pessimistic, 1.0}};
  const std::array steps{DirectedTest{Departure::pessimistic, 1e-9}, DirectedTest{Departure::optimistic, 0.3},
                         kNoData, DirectedTest{Departure::optimistic, 0.5}};
  const std::array families{TestFamily{0.5, run_means}, TestFamily{0.5, steps}};
  const JointTests joint = join_tests(families);
  EXPECT_TRUE(joint.optimistic(0.05) && joint.pessimistic(0.05));
  EXPECT_NEAR(joint.p_value, 6e-9, 1e-18);  // ½ of the level over three steps with data
  EXPECT_NEAR(joint.pessimistic_p_value, 6e-9, 1e-18);
  // The weight of the step that is rejected goes to the others: 1 − 1/6 over ¼.
  EXPECT_NEAR(joint.optimistic_p_value, 1e-4 * (5.0 / 6.0) / 0.25, 1e-15);
  EXPECT_TRUE(std::isnan(joint.adjusted[1][2]));
  EXPECT_EQ(joint.adjusted[0].size(), 2U);
}

TEST(JointTests, NothingToTest) {
  EXPECT_TRUE(std::isnan(join_tests({}).p_value));
  const std::array empty{kNoData};
  const JointTests joint = join_tests(std::array{TestFamily{1.0, empty}});
  EXPECT_TRUE(std::isnan(joint.p_value));
  EXPECT_FALSE(joint.optimistic(0.05));
  EXPECT_THROW(join_tests(std::array{TestFamily{0.0, empty}}), std::invalid_argument);
}

TEST(JointTests, KeepTheLevelForAllTogetherUnderDependence) {
  // Three families whose p-values share a common part, both directions of each: of 12 true hypotheses none
  // may be rejected in more than 5 % of the studies; a departure in one of them is told with its direction.
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(31);
  std::normal_distribution<double> normal;
  const auto p_upper = [](double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); };
  int any = 0;
  int found = 0;
  int misled = 0;
  for (int study = 0; study < kStudies; ++study) {
    const double common = normal(generator);
    std::array<std::array<DirectedTest, 4>, 3> tests;
    for (auto& family : tests) {
      for (std::size_t i = 0; i < 2; ++i) {
        const double z = std::sqrt(0.5) * (common + normal(generator));
        family[2 * i] = {Departure::optimistic, p_upper(z)};
        family[2 * i + 1] = {Departure::pessimistic, p_upper(-z)};
      }
    }
    std::array families{TestFamily{0.6, tests[0]}, TestFamily{0.3, tests[1]}, TestFamily{0.1, tests[2]}};
    any += join_tests(families).p_value <= 0.05;
    tests[1][1].p_value = p_upper(5.0 + normal(generator));
    const JointTests wrong = join_tests(families);
    found += wrong.pessimistic(0.05);
    misled += wrong.optimistic(0.05);
  }
  const double margin = 5.0 * test::binomial_standard_error(0.05, kStudies);
  EXPECT_LE(any / 4000.0, 0.05 + margin);
  EXPECT_GE(any / 4000.0, 0.02);
  EXPECT_GT(found / 4000.0, 0.97);
  EXPECT_LE(misled / 4000.0, 0.05 + margin);
}

}  // namespace
}  // namespace credence::internal
