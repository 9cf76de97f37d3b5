#include "analysis/stability/trace_growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace credence::internal {
namespace {

TraceGrowth of(const std::function<double(double)>& trace, int samples = 64) {
  std::vector<double> values;
  for (int k = 1; k <= samples; ++k) values.push_back(trace(k));
  return judge_growth(values, 1e-6);
}

TEST(TraceGrowth, TellsLimitsFromGrowth) {
  EXPECT_EQ(of([](double) { return 2.0; }).verdict, LongRun::bounded);
  EXPECT_EQ(of([](double k) { return 3.0 - 1.0 / k; }).verdict, LongRun::bounded);
  EXPECT_EQ(of([](double k) { return 1.0 / k; }).verdict, LongRun::bounded);
  EXPECT_EQ(of([](double k) { return 5.0 + 0.01 * k; }).verdict, LongRun::growing);
  EXPECT_EQ(of([](double k) { return std::log(k); }).verdict, LongRun::growing);
  EXPECT_EQ(of([](double k) { return std::exp(0.1 * k); }).verdict, LongRun::growing);
}

TEST(TraceGrowth, HasTheNumbersOfALine) {
  const TraceGrowth line = of([](double k) { return 0.5 * k; });
  EXPECT_NEAR(line.per_sample, 0.5, 1e-12);
  EXPECT_NEAR(line.exponent, 1.0, 1e-12);
}

TEST(TraceGrowth, BelowTheResolutionNothingIsSeen) {
  const std::vector<double> slow = {1.0, 1.0 + 1e-5, 1.0 + 2e-5, 1.0 + 3e-5, 1.0 + 4e-5};
  EXPECT_EQ(judge_growth(slow, 1e-3).verdict, LongRun::bounded);
  EXPECT_EQ(judge_growth(slow, 1e-6).verdict, LongRun::growing);
  EXPECT_EQ(judge_growth({1.0, 2.0, 3.0}, 1e-6).verdict, LongRun::failed);
}

}  // namespace
}  // namespace credence::internal
