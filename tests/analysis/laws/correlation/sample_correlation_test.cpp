#include "analysis/laws/correlation/sample_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/analysis/laws/moments_of.h"

namespace credence::internal {
namespace {

using testing::moments_of;

TEST(SampleCorrelation, IsThatOfTheDefinition) {
  // Of (1, 2, 6) and (10, 40, 10): −30/√(14 · 600).
  const auto R =
      sample_correlation(moments_of({Vector{{1.0, 10.0}}, Vector{{2.0, 40.0}}, Vector{{6.0, 10.0}}}));
  ASSERT_TRUE(R);
  EXPECT_NEAR((*R)(0, 1), -30.0 / std::sqrt(8400.0), 1e-14);
  EXPECT_NEAR((*R)(1, 0), (*R)(0, 1), 1e-15);
  EXPECT_NEAR((*R)(0, 0), 1.0, 1e-15);
  EXPECT_NEAR((*R)(1, 1), 1.0, 1e-15);
}

TEST(SampleCorrelation, KnowsNoUnits) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  VectorMoments plain, scaled;
  for (int i = 0; i < 20; ++i) {
    const double a = normal(generator), b = normal(generator), c = normal(generator);
    plain.add(Vector{{a, a + b, c - b}});
    scaled.add(Vector{{1e-80 * a, 1e60 * (a + b), -(c - b)}});
  }
  const Matrix R = *sample_correlation(plain), S = *sample_correlation(scaled);
  EXPECT_NEAR(R(0, 1), S(0, 1), 1e-12);
  EXPECT_NEAR(R(1, 2), -S(1, 2), 1e-12);
  EXPECT_NEAR(log_determinant(R), log_determinant(S), 1e-11);
}

TEST(SampleCorrelation, IsNotThereWhereOneDoesNotVary) {
  const Vector one = Vector::Constant(2, 0.1);
  EXPECT_FALSE(sample_correlation(moments_of({one})));
  EXPECT_FALSE(sample_correlation(moments_of({one, one, one})));
  EXPECT_FALSE(sample_correlation(moments_of({Vector{{0.1, 1.0}}, Vector{{0.1, 2.0}}})));
  EXPECT_FALSE(sample_correlation(moments_of({one, Vector{{std::nan(""), 1.0}}})));
  EXPECT_FALSE(sample_correlation(moments_of({one, Vector{{HUGE_VAL, 1.0}}})));
}

TEST(LogDeterminant, IsThatOfAPositiveDefiniteMatrixOnly) {
  Matrix R(2, 2);
  R << 1.0, 0.6, 0.6, 1.0;
  EXPECT_NEAR(log_determinant(R), std::log(0.64), 1e-15);
  EXPECT_EQ(log_determinant(Matrix::Identity(5, 5)), 0.0);
  EXPECT_NEAR(log_determinant(1e-200 * Matrix::Identity(5, 5)), -1000.0 * std::log(10.0), 1e-10);
  R << 1.0, 2.0, 2.0, 1.0;
  EXPECT_TRUE(std::isnan(log_determinant(R)));
  R << 1.0, 1.0, 1.0, 1.0;
  EXPECT_TRUE(std::isnan(log_determinant(R)));
  R << 1.0, std::nan(""), std::nan(""), 1.0;
  EXPECT_TRUE(std::isnan(log_determinant(R)));
}

TEST(SampleCorrelation, OfNothingIsNotThere) { EXPECT_FALSE(sample_correlation(VectorMoments{})); }

}  // namespace
}  // namespace credence::internal
