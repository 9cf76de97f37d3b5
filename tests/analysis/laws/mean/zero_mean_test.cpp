#include "analysis/laws/mean/zero_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "analysis/laws/mean/student.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

VectorMoments simulate(Index dim, int count, double bias, double scale, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  VectorMoments moments;
  for (int i = 0; i < count; ++i) {
    const Vector noise = Vector::NullaryExpr(dim, [&] { return normal(generator); });
    moments.add(scale * noise + Vector::Constant(dim, bias));
  }
  return moments;
}

TEST(InnovationMean, OneComponentIsStudentsT) {
  VectorMoments moments;
  for (const double u : {1.0, 2.0, 3.0, 4.0, 5.0}) moments.add(Vector::Constant(1, u));
  const ZeroMeanTest test = test_zero_mean(moments);
  EXPECT_NEAR(test.t_square, 18.0, 1e-12);    // (3 / √(2.5/5))²
  EXPECT_NEAR(test.p_value, 0.013235, 1e-5);  // t = 4.2426, 4 dof
}

TEST(InnovationMean, MergesToTheWhole) {
  std::mt19937_64 generator(1);
  const VectorMoments a = simulate(3, 10, 0.4, 1.0, generator);
  const VectorMoments b = simulate(3, 17, 0.4, 1.0, generator);
  std::mt19937_64 again(1);
  const VectorMoments whole = simulate(3, 27, 0.4, 1.0, again);
  VectorMoments merged;
  merged.merge(a);
  merged.merge(b);
  merged.merge(VectorMoments{});
  EXPECT_EQ(merged.count, 27);
  EXPECT_LT((merged.mean - whole.mean).norm(), 1e-12);
  EXPECT_LT((merged.scatter - whole.scatter).norm(), 1e-11);
  EXPECT_THROW(merged.add(Vector::Zero(2)), std::invalid_argument);
}

TEST(InnovationMean, CalibratedForFewValuesAndAnyScale) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(2);
  for (const double alpha : {0.05, 0.01}) {
    int t_square = 0;
    for (int study = 0; study < kStudies; ++study) {
      t_square += test_zero_mean(simulate(2, 12, 0.0, 2.0, generator)).p_value <= alpha;
    }
    const double five_errors = 5.0 * test::binomial_standard_error(alpha, kStudies);
    EXPECT_NEAR(static_cast<double>(t_square) / kStudies, alpha, five_errors);
  }
}

TEST(InnovationMean, FindsABias) {
  std::mt19937_64 generator(3);
  const ZeroMeanTest test = test_zero_mean(simulate(2, 1000, 0.2, 1.0, generator));
  EXPECT_LT(test.p_value, 1e-6);
  EXPECT_NEAR(test.mean(0), 0.2, 5.0 / std::sqrt(1000.0));
}

// Of two to 29 values of 15 components, whatever their covariance: at most the level, but for five standard
// errors of 2,000 studies, and no less than half of it. A mean of 8 in one of them is found from four on.
TEST(InnovationMean, OfFewValuesOfManyComponentsHoldsTheLevelAndFindsAMean) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  for (const int count : {2, 3, 5, 9, 12, 16, 29}) {
    const Matrix mix = Matrix::NullaryExpr(15, 15, [&] { return normal(generator); });
    int below_5 = 0, below_1 = 0;
    for (int study = 0; study < kStudies; ++study) {
      VectorMoments moments;
      for (int i = 0; i < count; ++i)
        moments.add(mix * Vector::NullaryExpr(15, [&] { return normal(generator); }));
      const double p = test_zero_mean(moments).p_value;
      below_5 += p <= 0.05;
      below_1 += p <= 0.01;
    }
    EXPECT_LE(below_5, 100 + 5 * std::sqrt(95.0)) << count;
    EXPECT_LE(below_1, 20 + 5 * std::sqrt(20.0)) << count;
    EXPECT_GE(below_5, 50 - 5 * std::sqrt(49.0)) << count;
  }
  for (const int count : {4, 5, 9, 12, 16, 29}) {
    VectorMoments moments;
    for (int i = 0; i < count; ++i) {
      Vector u = 0.3 * Vector::NullaryExpr(15, [&] { return normal(generator); });
      u[3] += 8.0;
      moments.add(u);
    }
    const ZeroMeanTest test = test_zero_mean(moments);
    EXPECT_LT(test.p_value, 1e-3) << count;
    EXPECT_TRUE(std::isnan(test.t_square)) << count;
  }
}

// A mean of 2.5 in one of nine components: by noncentral t and F of scipy t of each, at half of 5 %, finds it
// in 99.9 % of studies of eleven values, and Hotelling, of 2 dof, in 36 %.
TEST(InnovationMean, OfHardlyMoreValuesThanComponentsAMeanIsFound) {
  std::mt19937_64 generator(13);
  int found = 0;
  for (int study = 0; study < 200; ++study) {
    std::normal_distribution<double> normal;
    VectorMoments moments;
    for (int i = 0; i < 11; ++i) {
      Vector u = Vector::NullaryExpr(9, [&] { return normal(generator); });
      u[3] += 2.5;
      moments.add(u);
    }
    found += test_zero_mean(moments).p_value <= 0.05;
  }
  EXPECT_GE(found, 196);
  EXPECT_TRUE(std::isfinite(test_zero_mean(simulate(9, 18, 0.0, 1.0, generator)).t_square));
}

// w is along (2, 1), where the four values are 3√5, 2√5, 4√5 and 3√5 but for their sign: t = 3/√(2/3/4), of 3
// dof 7.348, which is that of both components, too.
TEST(InnovationMean, OfFewValuesHalfTheLevelIsThatOfTheLargestDirection) {
  VectorMoments moments;
  for (const double s : {3.0, 2.0, 4.0, 3.0}) moments.add(s * Vector{{2.0, 1.0}});
  const double p = student_two_sided_p_value(3.0 / std::sqrt(2.0 / 3.0 / 4.0), 3.0);
  EXPECT_NEAR(p, 0.005208, 1e-5);
  EXPECT_NEAR(test_zero_mean(moments).p_value, 2.0 * p, 1e-9);
}

// y = 2 x, and z = 0 as well: Student's t of x, three times its p-value.
TEST(InnovationMean, OfASingularCovarianceEachComponentIsTested) {
  std::mt19937_64 generator(12);
  std::normal_distribution<double> normal(0.5, 1.0);
  VectorMoments together, alone;
  for (int i = 0; i < 30; ++i) {
    const double x = normal(generator);
    together.add(Vector{{x, 2.0 * x, 0.0}});
    alone.add(Vector{{x}});
  }
  const double p = test_zero_mean(alone).p_value;
  EXPECT_NEAR(test_zero_mean(together).p_value, 3.0 * p, 1e-9 * p);
}

TEST(InnovationMean, TheMeanOfManyValuesThatAreAllTheSameIsCertain) {
  VectorMoments same;
  for (int i = 0; i < 10; ++i) same.add(Vector{{0.5, 0.0}});
  EXPECT_EQ(test_zero_mean(same).p_value, 0.0);
  VectorMoments zero;
  for (int i = 0; i < 10; ++i) zero.add(Vector::Zero(2));
  EXPECT_TRUE(std::isnan(test_zero_mean(zero).p_value));
  EXPECT_EQ(test_zero_mean(zero).reason, "the values do not vary");
}

TEST(InnovationMean, DegenerateDataGiveAReason) {
  EXPECT_FALSE(test_zero_mean(VectorMoments{}).reason.empty());
  VectorMoments few;
  few.add(Vector::Ones(3));
  few.add(Vector::Ones(3));
  EXPECT_FALSE(test_zero_mean(few).reason.empty());
  VectorMoments constant;
  for (int i = 0; i < 9; ++i) constant.add(Vector::Ones(2));
  EXPECT_FALSE(test_zero_mean(constant).reason.empty());
  VectorMoments bad = constant;
  bad.add(Vector::Constant(2, std::nan("")));
  EXPECT_FALSE(test_zero_mean(bad).reason.empty());
}

}  // namespace
}  // namespace credence::internal
