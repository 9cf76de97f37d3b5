#include "analysis/laws/scores/credibility.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

std::vector<Vector> gaussian_errors(const Matrix& covariance, int runs, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  const Matrix L = covariance.llt().matrixL();
  std::vector<Vector> errors;
  for (int run = 0; run < runs; ++run) {
    errors.push_back(L * Vector::NullaryExpr(L.rows(), [&] { return normal(generator); }));
  }
  return errors;
}

Matrix some_covariance() {
  Matrix P(3, 3);
  P << 4.0, 1.0, 0.2, 1.0, 2.0, -0.5, 0.2, -0.5, 1.0;
  return P;
}

TEST(Credibility, AFactorOnPIsThatManyDecibels) {
  // P claimed = Σ̂ / 2 exactly: every ρ is 2, so NCI = I² = 10 log₁₀ 2.
  std::mt19937_64 generator(1);
  const std::vector<Vector> errors = gaussian_errors(some_covariance(), 50, generator);
  Matrix sample = Matrix::Zero(3, 3);
  for (const Vector& e : errors) sample += e * e.transpose() / 50.0;
  const std::vector<Matrix> half(50, 0.5 * sample);
  EXPECT_NEAR(credibility_index(errors, half, 0.95).noncredibility, 10.0 * std::log10(2.0), 1e-9);
  EXPECT_NEAR(credibility_index(errors, half, 0.95).inclination, 10.0 * std::log10(2.0), 1e-9);
  const std::vector<Matrix> twice(50, 2.0 * sample);
  EXPECT_NEAR(credibility_index(errors, twice, 0.95).noncredibility, 10.0 * std::log10(2.0), 1e-9);
  EXPECT_NEAR(credibility_index(errors, twice, 0.95).inclination, -10.0 * std::log10(2.0), 1e-9);
}

TEST(Credibility, CalibratedAndItsExpectedValuesAreRight) {
  constexpr int kStudies = 2000;
  for (const int runs : {30, 100}) {
    const std::vector<Matrix> covariances(static_cast<std::size_t>(runs), some_covariance());
    std::mt19937_64 generator(2);
    int at_5 = 0;
    int at_1 = 0;
    int covered = 0;
    Moments inclination, noncredibility;
    CredibilityIndex index;
    for (int study = 0; study < kStudies; ++study) {
      index = credibility_index(gaussian_errors(covariances[0], runs, generator), covariances, 0.95);
      at_5 += index.p_value <= 0.05;
      at_1 += index.p_value <= 0.01;
      covered += index.lower <= 0.0 && 0.0 <= index.upper;
      inclination.add(index.inclination);
      noncredibility.add(index.noncredibility);
    }
    EXPECT_NEAR(at_5 / 2000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies)) << runs;
    EXPECT_NEAR(at_1 / 2000.0, 0.01, 5.0 * test::binomial_standard_error(0.01, kStudies)) << runs;
    EXPECT_EQ(covered, kStudies - at_5);
    const double error = std::sqrt(inclination.variance() / kStudies);
    EXPECT_NEAR(inclination.mean, index.expected_inclination, 5.0 * error) << runs;
    EXPECT_NEAR(noncredibility.mean / index.noncredibility_floor, 1.0, 0.1) << runs;
  }
}

// As of a filter with missed measurements: half of the runs claim, and have, 25 times the variance of the
// others.
TEST(Credibility, CalibratedWherePDiffersBetweenRuns) {
  constexpr int kStudies = 2000;
  constexpr int kRuns = 60;
  const Matrix often = some_covariance();
  const Matrix seldom = Vector{{5.0, 1.0, 2.0}}.asDiagonal() * often * Vector{{5.0, 1.0, 2.0}}.asDiagonal();
  std::vector<Matrix> covariances(kRuns, often);
  std::fill(covariances.begin() + kRuns / 2, covariances.end(), seldom);
  std::mt19937_64 generator(6);
  int at_5 = 0;
  int optimistic_at_5 = 0;
  Moments inclination, noncredibility;
  CredibilityIndex index;
  for (int study = 0; study < kStudies; ++study) {
    std::vector<Vector> errors = gaussian_errors(often, kRuns / 2, generator);
    std::ranges::move(gaussian_errors(seldom, kRuns / 2, generator), std::back_inserter(errors));
    index = credibility_index(errors, covariances, 0.95);
    at_5 += index.p_value <= 0.05;
    inclination.add(index.inclination);
    noncredibility.add(index.noncredibility);
    for (Vector& e : errors) e *= std::sqrt(1.3);
    const CredibilityIndex wrong = credibility_index(errors, covariances, 0.95);
    optimistic_at_5 += wrong.p_value <= 0.05 && wrong.lower > 0.0;
  }
  EXPECT_NEAR(at_5 / 2000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies));
  EXPECT_NEAR(inclination.mean, index.expected_inclination,
              5.0 * std::sqrt(inclination.variance() / kStudies));
  EXPECT_NEAR(noncredibility.mean / index.noncredibility_floor, 1.0, 0.1);
  // ln 1.3 of a standard deviation of √(2/180) on both sides: power Φ(0.262/0.1054 − 1.96) = 0.70.
  EXPECT_NEAR(optimistic_at_5 / 2000.0, 0.70, 5.0 * test::binomial_standard_error(0.70, kStudies));
}

TEST(Credibility, FindsAnOptimisticFilter) {
  std::mt19937_64 generator(3);
  const std::vector<Matrix> claimed(200, some_covariance() / 1.5);
  const CredibilityIndex index =
      credibility_index(gaussian_errors(some_covariance(), 200, generator), claimed, 0.95);
  EXPECT_LT(index.p_value, 1e-6);
  EXPECT_GT(index.lower, 0.0);
}

TEST(Credibility, DegenerateDataGiveAReason) {
  const std::vector<Matrix> P(9, Matrix::Identity(2, 2)), negative(9, -P[0]);
  EXPECT_FALSE(credibility_index({}, {}, 0.95).reason.empty());
  EXPECT_FALSE(
      credibility_index(std::vector<Vector>(2, Vector::Ones(2)), std::span(P).first(2), 0.95).reason.empty());
  EXPECT_FALSE(credibility_index(std::vector<Vector>(9, Vector::Ones(2)), P, 0.95).reason.empty());
  std::mt19937_64 generator(4);
  const std::vector<Vector> errors = gaussian_errors(P[0], 9, generator);
  EXPECT_FALSE(credibility_index(errors, negative, 0.95).reason.empty());
  EXPECT_TRUE(std::isnan(credibility_index(errors, negative, 0.95).p_value));
  EXPECT_THROW(credibility_index(errors, std::vector<Matrix>(3, P[0]), 0.95), std::invalid_argument);
  EXPECT_THROW(credibility_index(errors, std::vector<Matrix>(9, Matrix::Identity(3, 3)), 0.95),
               std::invalid_argument);
  EXPECT_THROW(credibility_index(errors, P, 1.5), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
