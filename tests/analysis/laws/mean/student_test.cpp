#include "analysis/laws/mean/student.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(Student, QuantilesAgreeWithClosedForms) {
  // t(1) is Cauchy, t(2) has the quantile √(2 (2p−1)² / (1 − (2p−1)²)); t(10) from printed tables.
  EXPECT_NEAR(student_quantile_two_sided(0.95, 1.0), std::tan(0.475 * M_PI), 1e-10);
  EXPECT_NEAR(student_quantile_two_sided(0.95, 2.0), std::sqrt(2.0 * 0.9025 / 0.0975), 1e-10);
  EXPECT_NEAR(student_quantile_two_sided(0.95, 10.0), 2.228, 5e-4);
  EXPECT_NEAR(student_quantile_two_sided(0.95, 1e9), 1.959963985, 1e-8);
  EXPECT_NEAR(student_two_sided_p_value(student_quantile_two_sided(0.99, 7.0), 7.0), 0.01, 1e-12);
}

TEST(Student, OneSidedPValues) {
  // t(1) is Cauchy.
  EXPECT_NEAR(student_upper_p_value(1.0, 1.0), 0.25, 1e-14);
  EXPECT_NEAR(student_upper_p_value(-1.0, 1.0), 0.75, 1e-14);
  EXPECT_EQ(student_upper_p_value(0.0, 5.0), 0.5);
  EXPECT_TRUE(std::isnan(student_upper_p_value(std::nan(""), 5.0)));
}

TEST(Student, IntervalOfAKnownSample) {
  Moments moments;
  for (const double x : {1.0, 2.0, 3.0, 4.0, 5.0}) moments.add(x);
  const MeanInterval interval = student_interval(moments, 0.95);
  EXPECT_DOUBLE_EQ(interval.mean, 3.0);
  EXPECT_NEAR(interval.standard_error, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(interval.half_width(), 2.776445 * std::sqrt(0.5), 1e-5);  // t_{0.975}(4)
}

TEST(Student, IntervalOfAnInconsistentFilterKeepsItsCoverage) {
  // NEES three times too large, 100 runs of dof 2: the empirical interval still covers, the χ² one does not.
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(3);
  std::chi_squared_distribution<double> chi(2.0);
  int covered = 0;
  for (int study = 0; study < kStudies; ++study) {
    Moments moments;
    for (int run = 0; run < 100; ++run) moments.add(3.0 * chi(generator));
    const MeanInterval interval = student_interval(moments, 0.95);
    covered += interval.lower <= 6.0 && 6.0 <= interval.upper;
  }
  // The skewness of χ²(2) costs 0.5 % (third-order term 2·skew²/n of Hall's expansion); 5 standard errors.
  const double rate = static_cast<double>(covered) / kStudies;
  EXPECT_NEAR(rate, 0.947, 5.0 * test::binomial_standard_error(0.95, kStudies)) << "got " << rate;
}

TEST(Student, DegenerateSamplesGiveAReason) {
  Moments none;
  EXPECT_FALSE(student_interval(none, 0.95).reason.empty());
  Moments one;
  one.add(2.0);
  const MeanInterval interval = student_interval(one, 0.95);
  EXPECT_FALSE(interval.reason.empty());
  EXPECT_TRUE(std::isnan(interval.lower));
  EXPECT_EQ(interval.mean, 2.0);

  Moments equal{.count = 5, .mean = 2.0, .m2 = 0.0};
  EXPECT_TRUE(student_interval(equal, 0.95).reason.empty());
  EXPECT_EQ(student_interval(equal, 0.95).lower, 2.0);
  EXPECT_EQ(student_interval(equal, 0.95).upper, 2.0);

  Moments infinite{.count = 5, .mean = std::numeric_limits<double>::infinity(), .m2 = std::nan("")};
  EXPECT_FALSE(student_interval(infinite, 0.95).reason.empty());
  EXPECT_THROW(student_interval(equal, 0.0), std::invalid_argument);
  EXPECT_THROW(student_quantile_two_sided(0.95, 0.0), std::invalid_argument);
  EXPECT_EQ(student_two_sided_p_value(std::numeric_limits<double>::infinity(), 3.0), 0.0);
}

}  // namespace
}  // namespace credence::internal
