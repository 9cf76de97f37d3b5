#include "analysis/laws/correlation/block_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

/// Values of 1 + 2 components, the first with this correlation to the second.
VectorMoments values(double correlation, int count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  VectorMoments moments;
  for (int i = 0; i < count; ++i) {
    Vector u(3);
    u[0] = normal(random);
    u[1] = correlation * u[0] + std::sqrt(1.0 - correlation * correlation) * normal(random);
    u[2] = 0.9 * u[1] + normal(random);  // within a group anything goes
    moments.add(u);
  }
  return moments;
}

TEST(BlockCorrelation, OfAKnownCorrelation) {
  VectorMoments moments;
  for (const auto& [x, y] :
       {std::pair{1.0, 1.0}, {-1.0, -1.0}, {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}, {-1.0, -1.0}}) {
    moments.add(Vector{{x, y}});
  }
  const BlockCorrelationTest test = test_block_correlation(moments, 1);
  EXPECT_NEAR(test.largest, 1.0 / 3.0, 1e-12);
  // One component against one: Student's t of 4 degrees of freedom, 1/3 √(4 / (8/9)).
  EXPECT_NEAR(test.p_value, 0.5185, 0.005);
}

TEST(BlockCorrelation, HoldsItsLevelWhateverTheCorrelationWithin) {
  std::mt19937_64 random(7);
  int alarms = 0;
  constexpr int kStudies = 2000;
  for (int i = 0; i < kStudies; ++i)
    alarms += test_block_correlation(values(0.0, 40, random), 1).p_value <= 0.05;
  EXPECT_NEAR(alarms / static_cast<double>(kStudies), 0.05, 5.0 * std::sqrt(0.05 * 0.95 / kStudies));
}

// Hardly more values than components: chi-square of the statistic rejects in 23 %.
TEST(BlockCorrelation, HoldsItsLevelOfManyComponentsAndFewValues) {
  std::mt19937_64 random(10);
  std::normal_distribution<double> normal;
  int alarms = 0;
  constexpr int kStudies = 4000;
  for (int i = 0; i < kStudies; ++i) {
    VectorMoments moments;
    for (int k = 0; k < 14; ++k) moments.add(Vector::NullaryExpr(12, [&] { return normal(random); }));
    alarms += test_block_correlation(moments, 6).p_value <= 0.05;
  }
  EXPECT_NEAR(alarms / static_cast<double>(kStudies), 0.05, 5.0 * std::sqrt(0.05 * 0.95 / kStudies));
}

TEST(BlockCorrelation, SeesWhatIsShared) {
  std::mt19937_64 random(8);
  const BlockCorrelationTest test = test_block_correlation(values(0.3, 500, random), 1);
  EXPECT_LT(test.p_value, 1e-4);
  EXPECT_NEAR(test.largest, 0.3, 0.2);
}

TEST(BlockCorrelation, SaysWhyThereIsNone) {
  EXPECT_EQ(test_block_correlation({}, 1).reason, "no values");
  std::mt19937_64 random(9);
  EXPECT_FALSE(test_block_correlation(values(0.0, 4, random), 1).reason.empty());
  EXPECT_THROW(test_block_correlation(values(0.0, 40, random), 3), std::invalid_argument);
  VectorMoments constant;
  for (int i = 0; i < 10; ++i) constant.add(Vector{{1.0, static_cast<double>(i)}});
  EXPECT_FALSE(test_block_correlation(constant, 1).reason.empty());
}

}  // namespace
}  // namespace credence::internal
