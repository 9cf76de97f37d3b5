#include "analysis/laws/scores/rmse_interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

TEST(Rmse, IntervalCoversForGaussianAndForCorrelatedErrors) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  for (const int runs : {20, 100}) {
    int scalar = 0;
    int mixed = 0;
    for (int study = 0; study < kStudies; ++study) {
      SkewedMoments one, two;
      for (int run = 0; run < runs; ++run) {
        const double a = normal(generator);
        const double b = 0.3 * normal(generator);
        one.add(a * a);
        two.add(a * a + b * b);
      }
      const RmseInterval of_one = rmse_interval(one, 0.95);
      const RmseInterval of_two = rmse_interval(two, 0.95);
      scalar += of_one.lower <= 1.0 && 1.0 <= of_one.upper;
      mixed += of_two.lower <= std::sqrt(1.09) && std::sqrt(1.09) <= of_two.upper;
    }
    // 40,000 studies give 0.940 and 0.936 for 20 runs, 0.947 and 0.946 for 100; 5 standard errors.
    const double expected = runs == 20 ? 0.938 : 0.9465;
    EXPECT_NEAR(static_cast<double>(scalar) / kStudies, expected, 0.02) << runs;
    EXPECT_NEAR(static_cast<double>(mixed) / kStudies, expected, 0.02) << runs;
  }
}

// Half of the mean square is of an error that stays as it is over the run, the rest averages out: the
// interval misses in 5.7 % of 20,000 studies of ten runs, by the cube root of a gamma law alone in 11.2.
TEST(Rmse, IntervalCoversWhereAnErrorStaysBesideOthersThatDoNot) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(6);
  std::normal_distribution<double> normal;
  std::gamma_distribution<double> averaged(100.0, 0.01);
  int missed = 0;
  for (int study = 0; study < kStudies; ++study) {
    SkewedMoments squares;
    for (int run = 0; run < 10; ++run) {
      const double stays = normal(generator);
      squares.add(0.5 * stays * stays + 0.5 * averaged(generator));
    }
    const RmseInterval interval = rmse_interval(squares, 0.95);
    missed += interval.lower > 1.0 || interval.upper < 1.0;
  }
  EXPECT_NEAR(static_cast<double>(missed) / kStudies, 0.057, 5.0 * std::sqrt(0.057 * 0.943 / kStudies));
}

TEST(Rmse, DegenerateDataGiveAReason) {
  EXPECT_FALSE(rmse_interval({}, 0.95).reason.empty());
  EXPECT_FALSE(rmse_interval({.count = 1, .mean = 4.0, .m2 = 0.0}, 0.95).reason.empty());
  EXPECT_EQ(rmse_interval({.count = 1, .mean = 4.0, .m2 = 0.0}, 0.95).rmse, 2.0);
  const RmseInterval equal = rmse_interval({.count = 5, .mean = 4.0, .m2 = 0.0}, 0.95);
  EXPECT_TRUE(equal.reason.empty());
  EXPECT_EQ(equal.lower, 2.0);
  EXPECT_EQ(equal.upper, 2.0);
  EXPECT_FALSE(rmse_interval({.count = 5, .mean = -1.0, .m2 = 1.0}, 0.95).reason.empty());
  EXPECT_FALSE(rmse_interval({.count = 5, .mean = std::numeric_limits<double>::infinity(), .m2 = 1.0}, 0.95)
                   .reason.empty());
  EXPECT_THROW(rmse_interval({.count = 5, .mean = 1.0, .m2 = 1.0}, 0.0), std::invalid_argument);
}

TEST(Rmse, IsTheRootOfTheMeanSquareInTheUnitOfTheErrors) {
  // Squares of 3, 5 and 4; errors ten times as large have ten times the interval.
  SkewedMoments squares, hundredfold;
  for (const double error : {3.0, 5.0, 4.0}) {
    squares.add(error * error);
    hundredfold.add(100.0 * error * error);
  }
  const RmseInterval small = rmse_interval(squares, 0.9), large = rmse_interval(hundredfold, 0.9);
  EXPECT_DOUBLE_EQ(small.rmse, std::sqrt(50.0 / 3.0));
  EXPECT_EQ(small.count, 3);
  EXPECT_LT(small.lower, small.rmse);
  EXPECT_GT(small.upper, small.rmse);
  EXPECT_NEAR(large.rmse, 10.0 * small.rmse, 1e-12 * large.rmse);
  EXPECT_NEAR(large.lower, 10.0 * small.lower, 1e-12 * large.lower);
  EXPECT_NEAR(large.upper, 10.0 * small.upper, 1e-12 * large.upper);
}

}  // namespace
}  // namespace credence::internal
