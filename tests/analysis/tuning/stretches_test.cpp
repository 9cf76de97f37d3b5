#include "analysis/tuning/stretches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/nan.h"

namespace credence::internal {
namespace {

// φ² of the squares of an autoregression: τ = (1 + φ²)/(1 − φ²).
TEST(Stretches, AreOfEightCorrelationTimes) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const double phi = 0.8;
  std::vector<double> squares;
  double u = normal(random);
  for (int i = 0; i < 40000; ++i) {
    squares.push_back(u * u);
    u = phi * u + std::sqrt(1.0 - phi * phi) * normal(random);
  }
  const double time = correlation_time_of(squares);
  EXPECT_NEAR(time, (1.0 + phi * phi) / (1.0 - phi * phi),
              0.9);  // 20 % : Sokal's error √(2 (2 W + 1)/N) is 5 %
  EXPECT_EQ(stretch_count(400, 5.0), 10);
  EXPECT_EQ(stretch_count(399, 5.0), 9);
  EXPECT_EQ(stretch_count(399, kNaN), 0);
}

TEST(Stretches, ValuesThatDoNotVaryHaveNoCorrelationTime) {
  EXPECT_TRUE(std::isnan(correlation_time_of(std::vector<double>(100, 2.0))));
  EXPECT_TRUE(std::isnan(correlation_time_of({})));
}

}  // namespace
}  // namespace credence::internal
