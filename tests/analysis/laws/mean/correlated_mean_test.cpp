#include "analysis/laws/mean/correlated_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

constexpr Index kLags = 20;

struct CorrelatedSeries {
  VectorMoments values;
  LagProducts products{2, kLags};
};

/// One run of two autoregressions of variance 1 about this mean.
CorrelatedSeries correlated_series(int length, double memory, double bias, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  CorrelatedSeries s;
  LagSeries series(2);
  Vector u(2);
  u << normal(random), normal(random);
  for (int k = 0; k < length; ++k) {
    const Vector value = u + Vector::Constant(2, bias);
    s.values.add(value);
    series.add(value);
    for (double& x : u) x = memory * x + std::sqrt(1.0 - memory * memory) * normal(random);
  }
  s.products.add_run(series);
  return s;
}

ZeroMeanTest tested(const CorrelatedSeries& s) { return test_correlated_mean(s.values, s.products, 0.95); }

TEST(CorrelatedMean, OfWhiteValuesIsTheExactTest) {
  const CorrelatedSeries s = correlated_series(300, 0.0, 0.1, 4);
  EXPECT_EQ(tested(s).p_value, test_zero_mean(s.values).p_value);
}

// 5 standard errors of the binomial count beyond the largest level that was measured, of 10 %; values taken
// for white would be rejected in most.
TEST(CorrelatedMean, CorrelationAloneIsNoBias) {
  constexpr int kStudies = 200;
  for (const double memory : {0.3, 0.8}) {
    int rejected = 0, as_white = 0;
    for (unsigned seed = 1; seed <= kStudies; ++seed) {
      const CorrelatedSeries s = correlated_series(400, memory, 0.0, seed);
      rejected += tested(s).p_value <= 0.05 ? 1 : 0;
      as_white += test_zero_mean(s.values).p_value <= 0.05 ? 1 : 0;
    }
    EXPECT_LE(rejected, 0.1 * kStudies + 5.0 * std::sqrt(0.1 * 0.9 * kStudies)) << memory;
    EXPECT_GT(as_white, 2 * rejected) << memory;
  }
}

TEST(CorrelatedMean, ABiasIsFound) {
  for (const double memory : {0.0, 0.3, 0.6}) {
    const ZeroMeanTest found = tested(correlated_series(1000, memory, 0.5, 7));
    EXPECT_LT(found.p_value, 1e-3) << memory;
    EXPECT_NEAR(found.mean[0], 0.5, 5.0 * std::sqrt((1.0 + memory) / (1.0 - memory) / 1000.0)) << memory;
  }
}

TEST(CorrelatedMean, WhatCannotBeKnownIsNotTested) {
  const ZeroMeanTest slow = tested(correlated_series(400, 0.99, 0.0, 1)),
                     few = tested(correlated_series(60, 0.9, 0.0, 1));
  EXPECT_TRUE(std::isnan(slow.p_value));
  EXPECT_EQ(slow.reason, "the values are correlated over more steps than are looked at");
  EXPECT_TRUE(std::isnan(few.p_value));
  EXPECT_EQ(few.reason, "too few values for their correlation in time");
}

}  // namespace
}  // namespace credence::internal
