#include "analysis/tuning/innovation_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

/// White innovations with true variances `scale` times those that the filter claims.
RecordedInnovations white_innovations(int count, double scale, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(scale));
  RecordedInnovations run;
  for (int i = 0; i < count; ++i) {
    run.whitened.emplace_back(Eigen::Vector2d(normal(random), normal(random)));
    run.nis.push_back(run.whitened.back().squaredNorm());
  }
  return run;
}

// Holm's adjustment keeps the chance that any of the four tests rejects at 5 %; 5 standard errors of the
// binomial count.
TEST(RecordedInnovations, FalseAlarmsAreAsRareAsTheyShouldBe) {
  constexpr int kRecordings = 200;
  int alarms = 0;
  for (unsigned seed = 0; seed < kRecordings; ++seed) {
    const InnovationTests tests =
        test_recorded_innovations(std::vector{white_innovations(300, 1.0, seed)}, 0.95);
    const auto& p = tests.adjusted_p_value;
    alarms += *std::min_element(p.begin(), p.end()) <= 0.05 ? 1 : 0;
  }
  const double most = 0.05 * kRecordings + 5 * std::sqrt(0.05 * 0.95 * kRecordings);
  EXPECT_LE(alarms, most);
  EXPECT_GT(alarms, 0) << "a test that never rejects tells nothing";
}

// Var(NIS/2) = 1 for 2 dof, so the scale's standard error is scale/√N.
TEST(RecordedInnovations, FindTheScaleOfTheNoise) {
  for (const double scale : {0.07, 4.0}) {
    const InnovationTests tests =
        test_recorded_innovations(std::vector{white_innovations(2000, scale, 2)}, 0.95);
    EXPECT_NEAR(tests.noise_scale.scale, scale, 5 * scale / std::sqrt(2000.0));
    EXPECT_EQ(tests.nis.verdict, scale < 1 ? Verdict::pessimistic : Verdict::optimistic);
    EXPECT_LT(tests.adjusted_p_value[1], 1e-6) << "the law";
    EXPECT_TRUE(tests.whiteness.white) << "a scale is no correlation";
  }
}

TEST(RecordedInnovations, ABiasAndCorrelationAreFound) {
  RecordedInnovations biased = white_innovations(2000, 1, 5), coloured = white_innovations(2000, 1, 6);
  for (Vector& u : biased.whitened) u(1) += 0.3;
  EXPECT_LT(test_recorded_innovations(std::vector{biased}, 0.95).adjusted_p_value[3], 1e-3);
  for (std::size_t i = 1; i < coloured.whitened.size(); ++i)
    coloured.whitened[i] = 0.8 * coloured.whitened[i - 1] + 0.6 * coloured.whitened[i];
  const InnovationTests tests = test_recorded_innovations(std::vector{coloured}, 0.95);
  EXPECT_FALSE(tests.whiteness.white);
  EXPECT_NEAR(tests.whiteness.autocorrelation[0], 0.8, 0.1);
  EXPECT_GT(tests.mean_p_value, 1e-3) << "correlation alone is no bias";
}

TEST(RecordedInnovations, OfTooShortARecordingTheMeanIsNotTested) {
  const InnovationTests tests = test_recorded_innovations(std::vector{white_innovations(10, 1, 7)}, 0.95);
  EXPECT_TRUE(std::isnan(tests.mean_p_value));
  const InnovationTests none = test_recorded_innovations(std::vector{RecordedInnovations{}}, 0.95);
  EXPECT_EQ(none.nis.verdict, Verdict::undecided);
  EXPECT_THROW(test_recorded_innovations({}, 0.95), std::invalid_argument);
  std::vector<RecordedInnovations> differ(2);
  differ[1].dof = 9;
  EXPECT_THROW(test_recorded_innovations(differ, 0.95), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
