#include "analysis/studies/selftest_comparisons.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace credence::internal {
namespace {

const TestResult& named(const std::vector<TestResult>& tests, const std::string& begin) {
  for (const TestResult& test : tests) {
    if (test.name.starts_with(begin)) return test;
  }
  throw std::out_of_range(begin);
}

// Levels are the selftest's own rows; here that each can fire.
TEST(SelftestComparisons, AChangeBetweenLogsIsSeen) {
  const SyntheticFilter exact({.noise_ratio = 0.1}), wrong({.noise_ratio = 0.1, .measurement_scale = 0.5});
  const NoiseSource noise(5, 77);
  EXPECT_LT(named(log_comparison_tests(exact, wrong, noise, 0), "change of any factor").p_value, 1e-6);
  EXPECT_EQ(named(log_comparison_tests(exact, exact, noise, 0), "change of any factor").p_value, 1.0);
}

TEST(SelftestComparisons, ANoiseThatIsWrongIsSeenAndItsFactorFound) {
  const std::vector<TestResult> tests = tuning_tests(3, 4.0);
  EXPECT_LT(named(tests, "likelihood ratio").p_value, 1e-12);
  // Of a factor of 4 on Q the interval is about the truth all the same.
  EXPECT_GT(named(tests, "interval of").p_value, 1e-6);
}

TEST(SelftestComparisons, OfOneSeedTheNumbersAreTheSame) {
  const auto first = estimator_tests(9), again = estimator_tests(9), other = estimator_tests(10);
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[1].p_value, again[1].p_value);
  EXPECT_NE(first[1].p_value, other[1].p_value);
}

}  // namespace
}  // namespace credence::internal
