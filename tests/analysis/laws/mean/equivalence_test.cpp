#include "analysis/laws/mean/equivalence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"
#include "tests/analysis/laws/golden_run_averages.h"

namespace credence::internal {
namespace {

TEST(Equivalence, TheLeastDeltaHasThePValueOfTheLevel) {
  for (const std::size_t runs : {8U, 24U}) {
    const SkewedMoments moments = test::golden_moments(runs);
    const double delta = proved_within(moments, 0.95);
    EXPECT_NEAR(equivalence_p_value(moments, delta), 0.05, 1e-8);
    EXPECT_GT(equivalence_p_value(moments, 0.99 * delta), 0.05);
  }
  EXPECT_TRUE(std::isnan(equivalence_p_value({}, 0.1)));
  EXPECT_TRUE(std::isnan(proved_within({}, 0.95)));
  EXPECT_EQ(proved_within({.count = 30}, 0.95), std::numeric_limits<double>::infinity());
  EXPECT_THROW(equivalence_p_value({}, 0.0), std::invalid_argument);
  EXPECT_TRUE(std::isnan(proved_within({.count = 30, .mean = 1.0, .m2 = 3.0}, 0.5))) << "proves nothing";
  EXPECT_THROW(proved_within({}, 0.49), std::invalid_argument);
}

SkewedMoments draw(double factor, double dof, int runs, std::mt19937_64& generator) {
  std::chi_squared_distribution<double> chi(dof);
  SkewedMoments moments;
  for (int run = 0; run < runs; ++run) moments.add(factor * chi(generator) / dof);
  return moments;
}

TEST(Equivalence, ProvesNoMoreThanIsTrueAndMostOfWhatIs) {
  constexpr int kStudies = 3000;
  std::mt19937_64 generator(61);
  const auto proved = [&](double factor) {  // 200 runs with averages of variance 0.1
    int count = 0;
    for (int study = 0; study < kStudies; ++study) {
      count += equivalence_p_value(draw(factor, 20.0, 200, generator), 0.1) <= 0.05;
    }
    return static_cast<double>(count) / kStudies;
  };
  const double margin = 5.0 * test::binomial_standard_error(0.05, kStudies);
  for (const double factor : {1.1, 1.0 / 1.1}) {
    const double wrongly = proved(factor);
    EXPECT_LE(wrongly, 0.05 + margin) << factor;
    // Hall's score must agree too.
    EXPECT_GE(wrongly, 0.05 - margin - 0.02) << factor;
  }
  // By the cube-root law of the mean, whose standard deviation c^½ is (0.1 / 1800)^½, with Student's
  // quantile.
  constexpr double kPower = 0.991;
  EXPECT_GE(proved(1.0), kPower - 5.0 * test::binomial_standard_error(kPower, kStudies) - 0.02);
}

TEST(Equivalence, TwentyRunsOfOneErrorThatStaysProveNoMoreThanIsTrue) {
  // 8.5 % by the skewness of the sample, 5.2 % now (docs/statistics.md).
  constexpr int kStudies = 8000;
  std::mt19937_64 generator(62);
  std::chi_squared_distribution<double> one(1.0);
  std::chi_squared_distribution<double> rest(2000.0);
  int proved = 0;
  for (int study = 0; study < kStudies; ++study) {
    SkewedMoments moments;
    for (int run = 0; run < 20; ++run) {
      moments.add(1.1 * (0.05 * one(generator) + 0.95 * rest(generator) / 2000.0));
    }
    proved += equivalence_p_value(moments, 0.1) <= 0.05;
  }
  EXPECT_LE(proved / 8000.0, 0.052 + 5.0 * test::binomial_standard_error(0.052, kStudies));
  EXPECT_GE(proved, 200);
}

}  // namespace
}  // namespace credence::internal
