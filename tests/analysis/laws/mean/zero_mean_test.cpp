#include "analysis/laws/mean/zero_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

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

// Twelve values of fifteen components: Student's t of each, Bonferroni over them. Of zero means at most 5 %
// are rejected, but for five standard errors of 2,000 studies; a mean of 2 is found.
TEST(InnovationMean, OfFewerValuesThanComponentsEachIsTested) {
  std::mt19937_64 generator(9);
  int rejected = 0;
  for (int study = 0; study < 2000; ++study)
    rejected += test_zero_mean(simulate(15, 12, 0.0, 1.0, generator)).p_value <= 0.05;
  EXPECT_LE(rejected, 100 + 5 * std::sqrt(95.0));
  EXPECT_GE(rejected, 100 - 7 * std::sqrt(95.0));  // (1 − 0.05/15)^15 = 0.951
  const ZeroMeanTest test = test_zero_mean(simulate(15, 12, 2.0, 1.0, generator));
  EXPECT_TRUE(test.reason.empty());
  EXPECT_LT(test.p_value, 1e-3);
  EXPECT_TRUE(std::isnan(test.t_square));
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
