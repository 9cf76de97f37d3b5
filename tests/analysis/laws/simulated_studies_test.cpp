#include "analysis/laws/simulated_studies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

// Of n values the mean of the moments is that of the law: mean 1, variance σ², third moment γ σ³ (n − 1)(n −
// 2)/n.
TEST(SimulatedStudies, HaveTheMomentsOfTheirLaw) {
  constexpr int kStudies = 20'000;
  constexpr std::int64_t kRuns = 10;
  for (const auto& [deviation, skewness] : {std::pair(0.3, 0.2), std::pair(0.2, 2.0)}) {
    SimulatedStudies studies(kStudies, deviation, skewness);
    Moments mean, variance, third;
    for (const SkewedMoments& m : studies.of_runs(kRuns)) {
      EXPECT_EQ(m.count, kRuns);
      mean.add(m.mean);
      variance.add(m.m2 / (kRuns - 1.0));
      third.add(m.m3 * kRuns / ((kRuns - 1.0) * (kRuns - 2.0)));
    }
    const auto error = [](const Moments& m) { return std::sqrt(m.variance() / kStudies); };
    EXPECT_NEAR(mean.mean, 1.0, 5.0 * error(mean));
    EXPECT_NEAR(variance.mean, deviation * deviation, 5.0 * error(variance));
    EXPECT_NEAR(third.mean, skewness * std::pow(deviation, 3), 5.0 * error(third));
  }
}

TEST(SimulatedStudies, TheirNumbersDoNotDependOnWhatWasAskedFirst) {
  SimulatedStudies once(3, 0.3, 1.0), often(3, 0.3, 1.0);
  for (const std::int64_t runs : {2, 7, 3}) often.of_runs(runs);
  const auto a = once.of_runs(7), b = often.of_runs(7);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a[i].mean, b[i].mean);
    EXPECT_EQ(a[i].m3, b[i].m3);
  }
  EXPECT_EQ(often.of_runs(2).size(), 3U);
  EXPECT_EQ(often.of_runs(2)[0].count, 2);
  EXPECT_THROW(once.of_runs(0), std::invalid_argument);
  EXPECT_THROW(SimulatedStudies(0, 0.3, 1.0), std::invalid_argument);
  EXPECT_THROW(SimulatedStudies(3, 0.3, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
