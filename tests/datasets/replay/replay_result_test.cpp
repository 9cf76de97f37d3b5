#include "datasets/replay/replay_result.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

TEST(ReplayResult, the_threshold_of_a_gate_is_the_quantile_of_two_degrees_of_freedom) {
  EXPECT_NEAR(gate_threshold(0.95), 5.991464547107979, 1e-14);  // any table
  EXPECT_NEAR(gate_threshold(0.99), 9.210340371976184, 1e-13);
  EXPECT_EQ(gate_threshold(0.0), 0.0);
}

// E[q | q ≤ g] of the density exp(−q/2)/2, by Simpson's rule.
TEST(ReplayResult, the_mean_within_a_gate_is_that_of_the_cut_law) {
  for (const double p : {0.1, 0.5, 0.9, 0.99, 0.999}) {
    const double g = gate_threshold(p);
    constexpr int kIntervals = 2000;
    double sum = 0.0;
    for (int i = 0; i <= kIntervals; ++i) {
      const double q = g * i / kIntervals, weight = i == 0 || i == kIntervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
      sum += weight * q * 0.5 * std::exp(-0.5 * q);
    }
    EXPECT_NEAR(expected_nis(p), sum * g / (3.0 * kIntervals) / p, 1e-9) << p;
  }
}

TEST(ReplayResult, without_a_gate_the_mean_is_two_and_within_a_narrow_one_half_its_width) {
  EXPECT_EQ(expected_nis(0.0), 2.0);
  EXPECT_NEAR(expected_nis(1.0 - 1e-12), 2.0, 1e-9);
  EXPECT_NEAR(expected_nis(1e-4), 0.5 * gate_threshold(1e-4), 1e-7);
}

TEST(ReplayResult, a_mean_without_values_is_zero) {
  ReplayMean mean;
  EXPECT_EQ(mean.mean(), 0.0);
  mean.add(3.0);
  mean.add(-1.0);
  EXPECT_EQ(mean.mean(), 1.0);
  EXPECT_EQ(mean.count, 2);
}

}  // namespace
}  // namespace credence::internal
