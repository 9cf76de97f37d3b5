#include "analysis/laws/mean/run_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/laws/mean/student_positive_mean.h"
#include "tests/analysis/evidence/synthetic_studies.h"
#include "tests/analysis/laws/golden_run_averages.h"

namespace credence::internal {
namespace {

/// As least_run_mean_p_value, of p-values.
struct SmallestOfAll {
  double p_value = 1.0;
  std::int64_t tests = 0;

  void add(double p) {
    if (std::isnan(p)) return;
    p_value = std::min(p_value, p);
    ++tests;
  }
};

TEST(RunMean, AgreesWithTheReference) {
  // sharp_verdict.py golden.
  const SkewedMoments all = test::golden_moments(24);
  EXPECT_NEAR(run_mean_p_values(all, 1.0, 3.0).optimistic, 0.3062705818427741, 1e-11);
  EXPECT_NEAR(run_mean_p_values(all, 1.0, 3.0).pessimistic, 0.7256439462155653, 1e-11);
  EXPECT_NEAR(run_mean_p_values(all, 1.5, 3.0).optimistic, 0.9039892313167982, 1e-11);
  EXPECT_NEAR(run_mean_p_values(all, 1.5, 3.0).pessimistic, 0.17799461769824054, 1e-11);
  const DirectedPValues few = run_mean_p_values(test::golden_moments(8), 1.5, 3.0);
  EXPECT_NEAR(few.optimistic, 0.9995350843306735, 1e-11);
  EXPECT_NEAR(few.pessimistic, 0.07164240311888327, 1e-10);
  EXPECT_NEAR(few.two_sided(), 2.0 * 0.07164240311888327, 1e-10);
}

// The same runs, but for the largest, which is 1.3: less skewed than χ²₁.
SkewedMoments moments_of_little_skewness() {
  SkewedMoments moments;
  for (const double x : test::kRunAverages) moments.add(x > 6.0 ? 1.3 : x);
  return moments;
}

TEST(RunMean, PessimisticSideAllowsForSkewnessThatFewRunsHardlyShow) {
  // By Simpson's rule for Student's law (Python, apart from the library).
  const SkewedMoments moments = moments_of_little_skewness();
  EXPECT_NEAR(run_mean_p_values(moments, 1.0).optimistic, 0.890537512658794, 1e-9);
  EXPECT_NEAR(run_mean_p_values(moments, 1.1).pessimistic, 0.033193334484460824, 1e-9);
  EXPECT_NEAR(run_mean_p_values(moments, 1.8).pessimistic, 0.004016557062718112, 1e-9);
}

TEST(RunMean, IntervalHoldsTheMeansThatAreNotRejected) {
  SkewedMoments narrow;  // nearly symmetric: Hall's inverse by its series
  for (int i = 0; i < 30; ++i) narrow.add(1.0 + 0.01 * (i % 2) + 1e-6 * i);
  SkewedMoments left;  // skewed to the left
  for (int i = 0; i < 40; ++i) left.add(1.0 - 1.0 / (1.0 + i));
  for (const SkewedMoments& moments :
       {test::golden_moments(24), test::golden_moments(8), test::golden_moments(2), test::golden_moments(1),
        narrow, left, moments_of_little_skewness()}) {
    for (const double confidence : {0.3, 0.5, 0.95, 0.999}) {
      const MeanInterval interval = run_mean_interval(moments, confidence, 3.0);
      const double tail = 0.5 * (1.0 - confidence);
      EXPECT_NEAR(run_mean_p_values(moments, interval.lower, 3.0).optimistic, tail, 1e-8) << moments.count;
      EXPECT_NEAR(run_mean_p_values(moments, interval.upper, 3.0).pessimistic, tail, 1e-8) << moments.count;
      EXPECT_LT(interval.lower, interval.upper);
    }
  }
}

// One constant error beside `others` independent ones.
SkewedMoments runs_of_mixed_law(double share, double others, int runs, std::mt19937_64& generator) {
  std::chi_squared_distribution<double> one(1.0);
  std::chi_squared_distribution<double> rest(others);
  SkewedMoments moments;
  for (int run = 0; run < runs; ++run) {
    moments.add(share * one(generator) + (1.0 - share) * rest(generator) / others);
  }
  return moments;
}

TEST(RunMean, MixedLawKeepsItsLevelWhereOneScoreDoesNot) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(11);
  for (const int runs : {3, 10, 20, 50}) {
    int optimistic = 0;
    int pessimistic = 0;
    int cube_alone = 0;
    for (int study = 0; study < kStudies; ++study) {
      const SkewedMoments moments = runs_of_mixed_law(1.0 / 3.0, 1e4, runs, generator);
      const DirectedPValues p = run_mean_p_values(moments, 1.0);
      optimistic += p.optimistic <= 0.025;
      pessimistic += p.pessimistic <= 0.025;
      cube_alone += positive_mean_p_value({moments.count, moments.mean, moments.m2}, 1.0) <= 0.05;
    }
    const double margin = 5.0 * test::binomial_standard_error(0.025, kStudies);
    EXPECT_LE(optimistic / 4000.0, 0.025 + margin) << runs;
    EXPECT_LE(pessimistic / 4000.0, 0.025 + margin) << runs;
    if (runs == 20) {
      EXPECT_GT(cube_alone / 4000.0, 0.075);
    }
  }
}

TEST(RunMean, PessimisticSideKeepsItsLevelOfOneErrorThatStaysAmongMany) {
  // 5.4 % with 20 runs by the skewness of the sample; docs/statistics.md has the levels expected.
  constexpr int kStudies = 8000;
  std::mt19937_64 generator(13);
  for (const int runs : {20, 50}) {
    int at_2_5 = 0;
    int at_0_1 = 0;
    for (int study = 0; study < kStudies; ++study) {
      const double p = run_mean_p_values(runs_of_mixed_law(0.05, 2000.0, runs, generator), 1.0).pessimistic;
      at_2_5 += p <= 0.025;
      at_0_1 += p <= 0.001;
    }
    EXPECT_LE(at_2_5 / 8000.0, 0.031 + 5.0 * test::binomial_standard_error(0.031, kStudies)) << runs;
    EXPECT_LE(at_0_1 / 8000.0, 0.002 + 5.0 * test::binomial_standard_error(0.002, kStudies)) << runs;
  }
}

TEST(RunMean, SeesAFactorOf5PercentInFiftyRuns) {
  // χ²(148)/148 has the variance of 100 steps of a constant-velocity filter (docs/statistics.md: 84 % and 79
  // %).
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(12);
  std::chi_squared_distribution<double> chi(148.0);
  int found_high = 0;
  int found_low = 0;
  for (int study = 0; study < kStudies; ++study) {
    SkewedMoments high;
    SkewedMoments low;
    for (int run = 0; run < 50; ++run) {
      const double x = chi(generator) / 148.0;
      high.add(1.05 * x);
      low.add(x / 1.05);
    }
    found_high += run_mean_p_values(high, 1.0).optimistic <= 0.025;
    found_low += run_mean_p_values(low, 1.0).pessimistic <= 0.025;
  }
  const double margin = 5.0 * test::binomial_standard_error(0.83, kStudies);
  EXPECT_GT(found_high / 2000.0, 0.83 - margin);
  EXPECT_GT(found_low / 2000.0, 0.79 - margin);
}

// Of 24 runs one that is 500 times the others: Hall's score alone would begin its interval below zero.
TEST(RunMean, NoIntervalOfAMeanOfSquaresBeginsBelowZero) {
  SkewedMoments moments;
  for (int run = 0; run < 24; ++run) moments.add(run == 0 ? 500.0 : 1.0 + 0.01 * run);
  EXPECT_EQ(run_mean_interval(moments, 0.95).lower, 0.0);
}

TEST(RunMean, TheLeastPValueOfManyIsThatOfOneAfterTheOther) {
  std::mt19937_64 bits(5);
  std::gamma_distribution<double> average(4.0, 0.25);
  for (const double expected : {0.9, 1.0, 1.1}) {
    std::vector<SkewedMoments> all;
    SmallestOfAll smallest;
    for (int i = 0; i < 300; ++i) {
      SkewedMoments moments;
      const int runs = i % 100 < 90 ? 40 : 15 + i % 10;
      for (int run = 0; run < runs; ++run) moments.add(i % 50 == 7 ? 1.0 : average(bits));
      if (i % 60 == 11) moments.add(std::numeric_limits<double>::infinity());
      all.push_back(moments);
      if (moments.count >= 18) smallest.add(run_mean_p_values(moments, expected).two_sided());
      const LeastPValue least = least_run_mean_p_value(all, expected, 18);
      ASSERT_EQ(least.p_value, smallest.p_value) << i;
      ASSERT_EQ(least.tests, smallest.tests) << i;
    }
    EXPECT_GT(smallest.tests, 280);
  }
  EXPECT_EQ(least_run_mean_p_value({}, 1.0, 1).tests, 0);
  EXPECT_THROW(least_run_mean_p_value({}, 0.0, 1), std::invalid_argument);
}

TEST(RunMean, DegenerateSamples) {
  EXPECT_TRUE(std::isnan(run_mean_p_values({}, 1.0).two_sided()));
  EXPECT_EQ(run_mean_interval({}, 0.95).reason, "no runs");
  EXPECT_TRUE(std::isnan(run_mean_p_values({.count = 4, .mean = -1.0}, 1.0).two_sided()));
  EXPECT_FALSE(run_mean_interval({.count = 4, .mean = std::nan("")}, 0.95).reason.empty());
  // Runs that are all equal.
  EXPECT_EQ(run_mean_p_values({.count = 30, .mean = 1.1}, 1.0).optimistic, 0.0);
  EXPECT_EQ(run_mean_p_values({.count = 30, .mean = 1.1}, 1.0).pessimistic, 1.0);
  EXPECT_EQ(run_mean_p_values({.count = 30, .mean = 1.0}, 1.0).two_sided(), 1.0);
  EXPECT_EQ(run_mean_p_values({.count = 30}, 1.0).pessimistic, 0.0);
  EXPECT_EQ(run_mean_interval({.count = 30, .mean = 1.1}, 0.95).upper, 1.1);
  // Errors of ±σ, written with nine digits.
  SkewedMoments rounded;
  for (int i = 0; i < 30; ++i) rounded.add(1.0 - 2e-10 + (i % 2 == 0 ? 1e-16 : 0.0));
  EXPECT_EQ(run_mean_p_values(rounded, 1.0).two_sided(), 1.0);
  EXPECT_EQ(run_mean_p_values({.count = 30, .mean = 1.0 - 1e-5}, 1.0).pessimistic, 0.0);
  // As good as equal: of a P of 1e160, where m2^1.5 and m3 are too small for a number.
  SkewedMoments tiny;
  for (int i = 0; i < 30; ++i) tiny.add(1e-160 * (1.0 + i % 3));
  EXPECT_EQ(run_mean_p_values(tiny, 1.0).optimistic, 1.0);
  EXPECT_EQ(run_mean_p_values(tiny, 1.0).pessimistic, 0.0);
  EXPECT_EQ(least_run_mean_p_value(std::vector{tiny}, 1.0, 2).p_value, 0.0);
  const MeanInterval interval = run_mean_interval(tiny, 0.95);
  EXPECT_GE(interval.lower, 0.0);
  EXPECT_LE(interval.lower, tiny.mean);
  EXPECT_GE(interval.upper, tiny.mean);
  EXPECT_LT(interval.upper, 1e-158);
  // One run of χ²(3): the bound, both ways.
  EXPECT_LT(run_mean_p_values({.count = 1, .mean = 6.0}, 1.0, 3.0).optimistic, 0.01);
  EXPECT_LT(run_mean_p_values({.count = 1, .mean = 0.01}, 1.0, 3.0).pessimistic, 0.01);
  EXPECT_THROW(run_mean_p_values({}, 0.0), std::invalid_argument);
  EXPECT_THROW(run_mean_p_values({}, 1.0, 0.0), std::invalid_argument);
  EXPECT_THROW(run_mean_interval({}, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
