#include "analysis/laws/mean/hall_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "analysis/laws/mean/student.h"
#include "tests/analysis/evidence/synthetic_studies.h"
#include "tests/analysis/laws/golden_run_averages.h"

namespace credence::internal {
namespace {

TEST(HallScore, IsStudentsScoreWithoutSkewness) {
  SkewedMoments symmetric;
  for (const double x : {1.0, 2.0, 3.0, 4.0, 5.0}) symmetric.add(x);
  EXPECT_EQ(sample_skewness(symmetric), 0.0);
  EXPECT_NEAR(hall_score(symmetric, 2.0), 1.0 / std::sqrt(2.5 / 5.0), 1e-14);
  EXPECT_NEAR(mean_of_hall_score(symmetric, hall_score(symmetric, 2.0)), 2.0, 1e-14);
}

TEST(HallScore, InverseOnBothBranchesAndMonotone) {
  for (const std::size_t runs : {4U, 24U}) {
    const SkewedMoments moments = test::golden_moments(runs);
    double last = 1e300;
    for (double mean = -3.0; mean < 9.0; mean += 0.25) {
      const double score = hall_score(moments, mean);
      EXPECT_LE(score, last);
      EXPECT_NEAR(mean_of_hall_score(moments, score), mean, 1e-8);
      EXPECT_NEAR(mean_of_hall_score(moments, hall_score(moments, mean, 2.5), 2.5), mean, 1e-8);
      last = score;
    }
  }
}

TEST(HallScore, RemovesTheSkewnessThatStudentsScoreHas) {
  // Values far below and above zero: no positivity is needed.
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(95);
  std::exponential_distribution<double> exponential;
  int plain = 0;
  int hall = 0;
  for (int study = 0; study < kStudies; ++study) {
    SkewedMoments moments;
    for (int run = 0; run < 40; ++run) moments.add(exponential(generator) - 1.0);
    plain += student_upper_p_value(-moments.mean / std::sqrt(moments.variance() / 40.0), 39.0) <= 0.025;
    hall += student_upper_p_value(-hall_score(moments, 0.0), 39.0) <= 0.025;
  }
  EXPECT_GT(plain / 4000.0, 0.05);
  EXPECT_LE(hall / 4000.0, 0.03 + 5.0 * test::binomial_standard_error(0.03, kStudies));
}

// Of {0.3, −0.1, −0.2, −4, 0.4, 0.1, −1.1, 0.2}, 3.5 dof, by the roots of Hall's polynomial (numpy,
// bisection).
TEST(HallInterval, ReachesFurtherToTheSideOfTheTail) {
  SkewedMoments moments;
  for (const double x : {0.3, -0.1, -0.2, -4.0, 0.4, 0.1, -1.1, 0.2}) moments.add(x);
  const MeanInterval interval = hall_interval(moments, 0.95);
  EXPECT_NEAR(interval.mean, -0.55, 1e-14);
  EXPECT_NEAR(interval.lower, -5.283353637427, 1e-8);
  EXPECT_NEAR(interval.upper, 0.444075266915, 1e-8);
  EXPECT_EQ(interval.count, 8);
}

TEST(PairedInterval, IsTheWiderOfBothAndItsPValueTheLarger) {
  SkewedMoments moments;
  for (const double x : {0.3, -0.1, -0.2, -4.0, 0.4, 0.1, -1.1, 0.2}) moments.add(x);
  const MeanInterval hall = hall_interval(moments, 0.95), both = paired_interval(moments, 0.95);
  const double error = std::sqrt(moments.variance() / 8.0);
  EXPECT_EQ(both.lower, hall.lower);
  EXPECT_NEAR(both.upper, moments.mean + student_quantile_two_sided(0.95, 3.5) * error, 1e-12);
  EXPECT_GT(both.upper, hall.upper);
  EXPECT_NEAR(paired_p_value(moments), student_two_sided_p_value(moments.mean / error, 3.5), 1e-12);
  // The end nearer to zero rejects zero at its own level and no more.
  for (const double shift : {both.lower, both.upper}) {
    SkewedMoments moved = moments;
    moved.mean -= shift;
    EXPECT_NEAR(paired_p_value(moved), 0.05, 1e-9) << shift;
  }
  SkewedMoments equal;
  EXPECT_TRUE(std::isnan(paired_p_value(equal)));
  for (int i = 0; i < 3; ++i) equal.add(0.0);
  EXPECT_EQ(paired_p_value(equal), 1.0);
  equal.mean = 0.5;
  EXPECT_EQ(paired_p_value(equal), 0.0);
}

TEST(PairedInterval, HoldsItsLevelForSkewedAndForSymmetricDifferences) {
  constexpr int kStudies = 4000, kRuns = 20;
  constexpr double kNominal = 0.05, kMost = 0.08;
  std::mt19937_64 generator(96);
  std::normal_distribution<double> normal;
  int student = 0, skewed = 0, symmetric = 0;
  for (int study = 0; study < kStudies; ++study) {
    SkewedMoments squares, plain;
    for (int run = 0; run < kRuns; ++run) {
      const double x = normal(generator);
      squares.add(x * x - 1.0);
      plain.add(normal(generator));
    }
    const double score = squares.mean / std::sqrt(squares.variance() / kRuns);
    student += student_two_sided_p_value(score, kRuns - 1.0) <= kNominal;
    skewed += paired_p_value(squares) <= kNominal;
    symmetric += paired_p_value(plain) <= kNominal;
  }
  const double error = 5.0 * test::binomial_standard_error(kMost, kStudies);
  EXPECT_GT(student, kStudies * (kMost + error));
  EXPECT_LE(skewed, kStudies * (kMost + error));
  EXPECT_LE(symmetric, kStudies * (kNominal + error));
  EXPECT_GE(symmetric, kStudies * (0.5 * kNominal)) << "it still rejects";
}

// By all M − 1 dof the squares are called different from their mean in 15, 11, 10 and 6 %.
TEST(PairedInterval, OfFewRunsHoldsItsLevelByHalfTheDof) {
  constexpr int kStudies = 4000;
  constexpr double kNominal = 0.05;
  const double most = kStudies * (kNominal + 5.0 * test::binomial_standard_error(kNominal, kStudies));
  std::mt19937_64 generator(97);
  std::normal_distribution<double> normal;
  for (const int runs : {2, 3, 5, 10}) {
    int skewed = 0, student = 0;
    for (int study = 0; study < kStudies; ++study) {
      SkewedMoments squares;
      for (int run = 0; run < runs; ++run) squares.add(std::pow(normal(generator), 2) - 1.0);
      skewed += paired_p_value(squares) <= kNominal;
      const double score = squares.mean / std::sqrt(squares.variance() / runs);
      student += student_two_sided_p_value(score, 0.5 * (runs - 1.0)) <= kNominal;
    }
    EXPECT_LE(skewed, most) << runs << " runs";
    EXPECT_GT(skewed, 0) << runs << " runs: it still rejects";
    EXPECT_GE(student, skewed) << runs << " runs: both scores must reject";
  }
}

TEST(HallInterval, IsStudentsWhereNothingIsSkewedOrNothingKnown) {
  SkewedMoments moments;
  EXPECT_EQ(hall_interval(moments, 0.95).reason, "no data");
  moments.add(2.0);
  EXPECT_EQ(hall_interval(moments, 0.95).reason, "one value has no variance");
  moments.add(2.0);
  EXPECT_EQ(hall_interval(moments, 0.95).lower, 2.0);
  EXPECT_EQ(hall_interval(moments, 0.95).upper, 2.0);
  SkewedMoments two;
  for (const double x : {1.0, 3.0}) two.add(x);
  EXPECT_NEAR(hall_interval(two, 0.95).lower, 2.0 - student_quantile_two_sided(0.95, 0.5), 1e-9);
  SkewedMoments large;
  for (const double x : {0.0, 0.0, 1e120}) large.add(x);
  EXPECT_FALSE(hall_interval(large, 0.95).reason.empty());
  EXPECT_TRUE(std::isnan(hall_interval(large, 0.95).lower));
  EXPECT_THROW(hall_interval(two, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
