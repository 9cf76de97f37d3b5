#include "analysis/laws/mean/student_positive_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(PositiveMean, IntervalHoldsTheMeansThatAreNotRejected) {
  const Moments moments{.count = 30, .mean = 2.4, .m2 = 110.0};
  for (const double confidence : {0.5, 0.95, 0.99}) {
    const MeanInterval interval = positive_mean_interval(moments, confidence);
    EXPECT_NEAR(positive_mean_p_value(moments, interval.lower), 1.0 - confidence, 1e-9);
    EXPECT_NEAR(positive_mean_p_value(moments, interval.upper), 1.0 - confidence, 1e-9);
    EXPECT_LT(interval.lower, 2.4);
    EXPECT_GT(interval.upper, 2.4);
  }
  for (const double mean : {1.5, 2.4, 6.0}) {
    EXPECT_NEAR(mean_of_positive_score(moments, positive_mean_score(moments, mean)), mean, 1e-12);
  }
  EXPECT_EQ(mean_of_positive_score(moments, -1e3), std::numeric_limits<double>::infinity());
}

TEST(PositiveMean, ManyValuesGiveStudentsInterval) {
  const Moments moments{.count = 1000000, .mean = 2.0, .m2 = 4.0e6};
  const MeanInterval cube = positive_mean_interval(moments, 0.95);
  const MeanInterval plain = student_interval(moments, 0.95);
  EXPECT_NEAR(cube.lower, plain.lower, 3e-3 * plain.half_width());
  EXPECT_NEAR(cube.upper, plain.upper, 3e-3 * plain.half_width());
}

TEST(PositiveMean, CalibratedWhereStudentIsNot) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(1);
  for (const double dof : {2.0, 10.0}) {
    std::chi_squared_distribution<double> chi(dof);
    for (const int runs : {20, 100}) {
      int at_5 = 0;
      int at_1 = 0;
      int plain_at_1 = 0;
      for (int study = 0; study < kStudies; ++study) {
        Moments moments;
        for (int run = 0; run < runs; ++run) moments.add(chi(generator));
        const double p = positive_mean_p_value(moments, dof);
        at_5 += p <= 0.05;
        at_1 += p <= 0.01;
        const double t = (moments.mean - dof) / std::sqrt(moments.variance() / runs);
        plain_at_1 += student_two_sided_p_value(t, runs - 1.0) <= 0.01;
      }
      EXPECT_NEAR(at_5 / 4000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies)) << dof;
      EXPECT_NEAR(at_1 / 4000.0, 0.01, 5.0 * test::binomial_standard_error(0.01, kStudies)) << dof;
      if (dof == 2.0 && runs == 20) {
        EXPECT_GT(plain_at_1 / 4000.0, 0.025);
      }
    }
  }
}

TEST(PositiveMean, DegenerateSamples) {
  EXPECT_TRUE(std::isnan(positive_mean_p_value({}, 1.0)));
  EXPECT_TRUE(std::isnan(positive_mean_p_value({.count = 1, .mean = 2.0, .m2 = 0.0}, 1.0)));
  EXPECT_EQ(positive_mean_p_value({.count = 4, .mean = 2.0, .m2 = 0.0}, 2.0), 1.0);
  EXPECT_EQ(positive_mean_p_value({.count = 4, .mean = 2.0, .m2 = 0.0}, 1.0), 0.0);
  EXPECT_FALSE(positive_mean_interval({}, 0.95).reason.empty());
  EXPECT_FALSE(positive_mean_interval({.count = 4, .mean = -2.0, .m2 = 1.0}, 0.95).reason.empty());
  EXPECT_EQ(positive_mean_interval({.count = 4, .mean = 2.0, .m2 = 0.0}, 0.95).upper, 2.0);
  // One of twenty values holds everything: x̄ = 1, Σ (x − x̄)² = 19 + 19².
  EXPECT_EQ(positive_mean_interval({.count = 20, .mean = 1.0, .m2 = 380.0}, 0.95).lower, 1.0);
  // Two values, one zero: no mean is too large.
  const MeanInterval two = positive_mean_interval({.count = 2, .mean = 1.0, .m2 = 2.0}, 0.95);
  EXPECT_EQ(two.upper, std::numeric_limits<double>::infinity());
  EXPECT_THROW(positive_mean_p_value({.count = 4, .mean = 2.0, .m2 = 1.0}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
