#include "analysis/laws/equivalence.h"

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
    const double delta = proved_within(moments, 0.95, 3.0);
    EXPECT_NEAR(equivalence_p_value(moments, delta, 3.0), 0.05, 1e-8);
    EXPECT_GT(equivalence_p_value(moments, 0.99 * delta, 3.0), 0.05);
  }
  EXPECT_TRUE(std::isnan(equivalence_p_value({}, 0.1)));
  EXPECT_TRUE(std::isnan(proved_within({}, 0.95)));
  EXPECT_EQ(proved_within({.count = 30}, 0.95), std::numeric_limits<double>::infinity());
  EXPECT_THROW(equivalence_p_value({}, 0.0), std::invalid_argument);
  EXPECT_THROW(proved_within({}, 0.5), std::invalid_argument);
}

SkewedMoments draw(double factor, double dof, int runs, std::mt19937_64& generator) {
  std::chi_squared_distribution<double> chi(dof);
  SkewedMoments moments;
  for (int run = 0; run < runs; ++run) moments.add(factor * chi(generator) / dof);
  return moments;
}

TEST(Equivalence, ProvesNoMoreThanIsTrueAndHasTheStatedPower) {
  // Averages of variance 0.1, 200 runs.
  constexpr int kStudies = 3000;
  std::mt19937_64 generator(61);
  for (const double factor : {1.1, 1.0 / 1.1, 1.0}) {
    int proved = 0;
    for (int study = 0; study < kStudies; ++study) {
      proved += equivalence_p_value(draw(factor, 20.0, 200, generator), 0.1) <= 0.05;
    }
    const double power = equivalence_power(200.0, 0.1, 0.1, 0.05, factor);
    const double margin = 5.0 * test::binomial_standard_error(power, kStudies);
    EXPECT_LE(proved / 3000.0, power + margin) << factor;
    // Hall's score must agree too.
    EXPECT_GE(proved / 3000.0, power - margin - 0.02) << factor;
    if (factor == 1.0) {
      EXPECT_GT(power, 0.95);
    } else {
      EXPECT_NEAR(power, 0.05, 0.003);
    }
  }
}

TEST(Equivalence, RunsNeeded) {
  // Variances of the run averages of a constant-velocity filter and of monobot SLAM, as sharp_verdict.py has
  // them.
  EXPECT_EQ(runs_for_equivalence(0.0135, 0.1, 0.05, 0.8), 20);
  const std::int64_t slam = runs_for_equivalence(0.337, 0.1, 0.05, 0.8);
  EXPECT_NEAR(static_cast<double>(slam), 318.0, 5.0);
  EXPECT_GE(equivalence_power(static_cast<double>(slam), 0.337, 0.1, 0.05), 0.8);
  EXPECT_LT(equivalence_power(static_cast<double>(slam) - 1.0, 0.337, 0.1, 0.05), 0.8);
  EXPECT_EQ(equivalence_power(20.0, 0.337, 0.1, 0.05), 0.0);
  EXPECT_THROW(runs_for_equivalence(0.1, 1e-9, 0.05, 0.8), std::invalid_argument);
  EXPECT_THROW(equivalence_power(19.0, 0.1, 0.1, 0.05), std::invalid_argument);
  EXPECT_THROW(equivalence_power(20.0, 0.1, 0.1, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
