#include "analysis/laws/correlation/error_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

VectorMoments correlated_errors(double correlation, double scale, int runs, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  VectorMoments moments;
  for (int run = 0; run < runs; ++run) {
    const double a = normal(generator), b = normal(generator), c = normal(generator);
    moments.add(scale * Eigen::Vector3d(a, correlation * a + std::sqrt(1.0 - correlation * correlation) * b,
                                        2.0 * c));
  }
  return moments;
}

TEST(ErrorCorrelation, TwoComponentsInClosedForm) {
  // (±1, ±1) with correlation ½: scatter [4 2; 2 4], det R = ¾.
  VectorMoments moments;
  for (const auto& [x, y] : {std::pair{1.0, 1.0},
                             {1.0, 1.0},
                             {-1.0, -1.0},
                             {-1.0, -1.0},
                             {1.0, 1.0},
                             {-1.0, -1.0},
                             {1.0, -1.0},
                             {-1.0, 1.0}}) {
    moments.add(Eigen::Vector2d(x, y));
  }
  const ErrorCorrelationTest test = test_error_correlation(moments);
  EXPECT_NEAR(test.largest, 0.5, 1e-14);
  EXPECT_EQ(test.dof, 1.0);
  // Student: t = 1/2 sqrt(6 / (3/4)) of 6 degrees of freedom.
  EXPECT_NEAR(test.p_value, 0.2070, 0.003);
}

TEST(ErrorCorrelation, KeepsItsLevelAndSeesNoScale) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(1);
  int alarms = 0;
  for (int study = 0; study < kStudies; ++study) {
    alarms += test_error_correlation(correlated_errors(0.0, 3.0, 30, generator)).p_value <= 0.05;
  }
  EXPECT_NEAR(static_cast<double>(alarms) / kStudies, 0.05,
              5.0 * test::binomial_standard_error(0.05, kStudies));
}

// Hardly more runs than states: chi-square of the statistic rejects in 18 %.
TEST(ErrorCorrelation, KeepsItsLevelOfManyStatesAndFewRuns) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  int alarms = 0;
  for (int study = 0; study < kStudies; ++study) {
    VectorMoments moments;
    for (int run = 0; run < 20; ++run)
      moments.add(Vector::NullaryExpr(15, [&] { return normal(generator); }));
    alarms += test_error_correlation(moments).p_value <= 0.05;
  }
  EXPECT_NEAR(static_cast<double>(alarms) / kStudies, 0.05,
              5.0 * test::binomial_standard_error(0.05, kStudies));
}

TEST(ErrorCorrelation, FindsACorrelation) {
  std::mt19937_64 generator(2);
  int found = 0;
  for (int study = 0; study < 200; ++study) {
    found += test_error_correlation(correlated_errors(0.6, 1.0, 50, generator)).p_value <= 0.01;
  }
  EXPECT_GT(found, 180);
}

TEST(ErrorCorrelation, DegenerateInput) {
  EXPECT_FALSE(test_error_correlation({}).reason.empty());
  VectorMoments few, flat, dependent;
  for (int i = 0; i < 3; ++i) few.add(Eigen::Vector2d(i, 1.0 - i * i));
  for (int i = 0; i < 9; ++i) {
    flat.add(Eigen::Vector2d(i, 1.0));
    dependent.add(Eigen::Vector2d(i, i));
  }
  EXPECT_FALSE(test_error_correlation(few).reason.empty());
  EXPECT_FALSE(test_error_correlation(flat).reason.empty());
  const ErrorCorrelationTest same = test_error_correlation(dependent);
  EXPECT_TRUE(!same.reason.empty() || same.p_value < 1e-6);
}

}  // namespace
}  // namespace credence::internal
