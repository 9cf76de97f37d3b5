#include "analysis/laws/shape/component_variances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace credence::internal {
namespace {

Moments moments_of(std::int64_t count, double mean) {
  Moments m;
  for (std::int64_t i = 0; i < count; ++i) m.add(mean);
  return m;
}

// χ² of 20 dof: P(> 37.56623) = 0.01 and P(< 8.26040) = 0.01 (tables, as Abramowitz and Stegun 26.8); its 2.5
// and 97.5 % quantiles are 9.59078 and 34.16961.
TEST(ComponentVariances, AreTheQuantilesOfChiSquare) {
  const std::vector<Moments> values = {moments_of(20, 37.56623 / 20.0), moments_of(20, 1.0)};
  const ComponentTest test = test_components(values, 0.95);
  EXPECT_EQ(test.worst, 0);
  EXPECT_NEAR(test.p_value.optimistic, 2.0 * 2.0 * 0.01, 1e-7);
  EXPECT_NEAR(test.components[0].p_value.optimistic, 2.0 * 0.01, 1e-7);
  EXPECT_GT(test.p_value.pessimistic, 0.5);
  EXPECT_NEAR(test.components[1].lower, 20.0 / 34.16961, 1e-6);
  EXPECT_NEAR(test.components[1].upper, 20.0 / 9.59078, 1e-6);

  const std::vector<Moments> small = {moments_of(20, 1.0), moments_of(20, 1.0),
                                      moments_of(20, 8.26040 / 20.0)};
  EXPECT_EQ(test_components(small, 0.95).worst, 2);
  EXPECT_NEAR(test_components(small, 0.95).p_value.pessimistic, 2.0 * 3.0 * 0.01, 1e-6);
}

// Sixty steps that are worth twenty.
TEST(ComponentVariances, CorrelatedStepsAreWorthFewer) {
  const std::vector<Moments> values = {moments_of(60, 37.56623 / 20.0), moments_of(60, 1.0)};
  const ComponentTest test = test_components(values, 0.95, 3.0);
  EXPECT_NEAR(test.components[0].p_value.optimistic, 2.0 * 0.01, 1e-7);
  EXPECT_NEAR(test.components[1].upper, 20.0 / 9.59078, 1e-6);
  EXPECT_EQ(test.components[1].count, 60);
}

TEST(ComponentVariances, OfFactorsBeyondArithmeticTheLargestIsTheWorst) {
  const std::vector<Moments> values = {moments_of(5000, 100.0), moments_of(5000, 3000.0)};
  const ComponentTest test = test_components(values, 0.95);
  EXPECT_EQ(test.p_value.optimistic, 0.0);
  EXPECT_EQ(test.worst, 1);
}

TEST(ComponentVariances, OneComponentOrNoneIsNoTest) {
  for (const std::vector<Moments>& values :
       {std::vector<Moments>{}, {moments_of(20, 1.0)}, {Moments{}, Moments{}}}) {
    const ComponentTest test = test_components(values, 0.95);
    EXPECT_FALSE(test.reason.empty());
    EXPECT_TRUE(test.components.empty());
  }
  const std::vector<Moments> silent = {moments_of(20, 1.0), Moments{}};
  EXPECT_TRUE(test_components(silent, 0.95).reason.empty());
  EXPECT_TRUE(std::isnan(test_components(silent, 0.95).components[1].mean));
  EXPECT_THROW(test_components(silent, 1.0), std::invalid_argument);
}

// Three components that are correlated by 0.6, in single steps and averaged over two observations that are
// correlated by 0.8: rejected as often as stated, or less.
TEST(ComponentVariances, AnExactFilterIsRejectedNoMoreOftenThanStated) {
  constexpr int kStudies = 4000, kSteps = 40;
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal;
  for (const int observations : {1, 2}) {
    int rejected = 0;
    for (int study = 0; study < kStudies; ++study) {
      std::vector<Moments> values(3);
      for (int step = 0; step < kSteps; ++step) {
        double shared[3];
        for (double& x : shared) x = normal(random);
        double sum[3] = {0.0, 0.0, 0.0};
        for (int o = 0; o < observations; ++o) {
          double z[3];
          const double own = observations == 1 ? 1.0 : std::sqrt(0.2),
                       common = observations == 1 ? 0.0 : std::sqrt(0.8);
          for (int j = 0; j < 3; ++j) z[j] = own * normal(random) + common * shared[j];
          const double first = z[0];
          for (int j = 0; j < 3; ++j) {
            const double nu = j == 0 ? z[0] : 0.6 * first + 0.8 * z[j];
            sum[j] += nu * nu / observations;
          }
        }
        for (int j = 0; j < 3; ++j) values[static_cast<std::size_t>(j)].add(sum[j]);
      }
      const ComponentTest test = test_components(values, 0.95);
      rejected += std::min(test.p_value.optimistic, test.p_value.pessimistic) <= 0.05;
    }
    const double most = 0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies);
    EXPECT_LE(rejected, most) << observations;
    if (observations == 1) EXPECT_GE(rejected, 0.03 * kStudies) << "and hardly less often";
  }
}

// A variance that is twice too small in one of two components, in 100 steps: Σ ν²/S is 2 χ²(100), beyond the
// quantile 1 − 0.05/4 of χ²(100) = 134.4 with probability P(χ²(100) > 67.2) = 0.995.
TEST(ComponentVariances, AVarianceTwiceTooSmallIsSeenInAHundredSteps) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  int seen = 0;
  for (int study = 0; study < 1000; ++study) {
    std::vector<Moments> values(2);
    for (int step = 0; step < 100; ++step) {
      values[0].add(std::pow(normal(random), 2));
      values[1].add(2.0 * std::pow(normal(random), 2));
    }
    const ComponentTest test = test_components(values, 0.95);
    seen += test.p_value.optimistic <= 0.05 && test.worst == 1;
  }
  EXPECT_GE(seen, 995 - 5.0 * std::sqrt(1000 * 0.995 * 0.005));
}

}  // namespace
}  // namespace credence::internal
