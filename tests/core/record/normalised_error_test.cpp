#include "core/record/normalised_error.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

TEST(NormalisedError, FullRankIsThePlainForm) {
  Matrix P(2, 2);
  P << 4.0, 1.0, 1.0, 9.0;
  Vector e(2);
  e << 1.0, -2.0;
  const NormalisedError result = normalised_error(e, P);
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_NEAR(result.value, e.dot(P.llt().solve(e)), 1e-14);
  EXPECT_EQ(result.dof, 2);
  const Matrix L = P.llt().matrixL();
  EXPECT_LT((L * result.whitened - e).norm(), 1e-14);
}

TEST(NormalisedError, KnownStatesLowerTheDofAndAreListed) {
  Matrix P = Matrix::Zero(4, 4);
  P(1, 1) = 4.0;
  P(3, 3) = 1.0;
  P(1, 3) = P(3, 1) = 1.0;
  Vector e(4);
  e << 0.0, 2.0, 0.0, 1.0;
  const NormalisedError result = normalised_error(e, P);
  ASSERT_TRUE(result.ok);
  EXPECT_EQ(result.dof, 2);
  EXPECT_NEAR(result.value, 4.0 / 3.0, 1e-14);
}

TEST(NormalisedError, AnErrorInAKnownStateIsInfinitelyUnlikely) {
  Matrix P = Matrix::Identity(2, 2);
  P(0, 0) = 0.0;
  const NormalisedError result = normalised_error(Vector::Ones(2), P);
  ASSERT_TRUE(result.ok);
  EXPECT_EQ(result.value, std::numeric_limits<double>::infinity());
}

TEST(NormalisedError, SingularCovarianceUsesItsRange) {
  // Two states that are equal up to a factor, in very different units, and a free one.
  Vector direction(3);
  direction << 1e-6, 2e3, 0.0;
  Vector free(3);
  free << 0.0, 0.0, 1e-3;
  const Matrix P = direction * direction.transpose() + free * free.transpose();
  const NormalisedError inside = normalised_error(0.5 * direction - 2.0 * free, P);
  ASSERT_TRUE(inside.ok) << inside.reason;
  EXPECT_EQ(inside.dof, 2);
  EXPECT_NEAR(inside.value, 4.25, 1e-9);
  Vector outside = direction;
  outside(0) = -1e-6;
  EXPECT_EQ(normalised_error(outside, P).value, std::numeric_limits<double>::infinity());
}

TEST(NormalisedError, NearlySingularButRegularKeepsItsDof) {
  Matrix P(2, 2);
  P << 1.0, 1.0 - 1e-12, 1.0 - 1e-12, 1.0;
  EXPECT_EQ(normalised_error(Vector::Zero(2), P).dof, 2);
}

// The rounding of many steps makes eigenvalues of a singular P negative, and is no reason to reject it.
TEST(NormalisedError, ANegativeEigenvalueOfRoundingIsZero) {
  const auto of = [](double correlation) {
    const Matrix P{{1.0, correlation}, {correlation, 1.0}};
    return normalised_error(Vector{{1.0, 1.0}}, P);
  };
  ASSERT_TRUE(of(1.0 + 2e-13).ok) << of(1.0 + 2e-13).reason;
  EXPECT_EQ(of(1.0 + 2e-13).dof, 1);
  EXPECT_NEAR(of(1.0 + 2e-13).value, 1.0, 1e-12);
  EXPECT_FALSE(of(1.0 + 1e-11).ok);
}

TEST(NormalisedError, IsNotFooledByUnits) {
  Matrix P = Matrix::Zero(2, 2);
  P(0, 0) = 1e-20;
  P(1, 1) = 1e20;
  const NormalisedError result = normalised_error(P.diagonal().cwiseSqrt(), P);
  EXPECT_EQ(result.dof, 2);
  EXPECT_NEAR(result.value, 2.0, 1e-12);
}

TEST(NormalisedError, WhatIsNoCovarianceIsSaidAndNotRepaired) {
  Matrix indefinite(2, 2);
  indefinite << 1.0, 2.0, 2.0, 1.0;
  EXPECT_FALSE(normalised_error(Vector::Ones(2), indefinite).ok);
  EXPECT_FALSE(normalised_error(Vector::Ones(2), -Matrix::Identity(2, 2)).ok);
  Matrix impossible = Matrix::Identity(2, 2);
  impossible(0, 0) = 0.0;
  impossible(0, 1) = impossible(1, 0) = 0.1;
  EXPECT_FALSE(normalised_error(Vector::Ones(2), impossible).ok);
  Matrix nan = Matrix::Identity(2, 2);
  nan(0, 1) = std::nan("");
  EXPECT_FALSE(normalised_error(Vector::Ones(2), nan).ok);
  EXPECT_FALSE(normalised_error(Vector::Constant(2, std::nan("")), Matrix::Identity(2, 2)).ok);
  EXPECT_FALSE(normalised_error(Vector::Ones(2), indefinite).reason.empty());
  EXPECT_TRUE(std::isnan(normalised_error(Vector::Ones(2), indefinite).value));
  EXPECT_THROW(normalised_error(Vector::Ones(3), indefinite), std::invalid_argument);
}

TEST(NormalisedError, AllKnownIsZeroDof) {
  const NormalisedError result = normalised_error(Vector::Zero(2), Matrix::Zero(2, 2));
  EXPECT_TRUE(result.ok);
  EXPECT_EQ(result.dof, 0);
  EXPECT_EQ(result.value, 0.0);
}

TEST(NormalisedError, WhitenedSingularErrorsAreStandardNormal) {
  // e = B w with B 4×2: rank 2, so NEES ~ χ²(2): mean 2, variance 4 within 5 standard errors.
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  Matrix B(4, 2);
  B << 1.0, 0.5, -2.0, 1.0, 0.0, 3.0, 1.0, 1.0;
  const Matrix P = B * B.transpose();
  constexpr int kErrors = 5000;
  Vector nees(kErrors);
  for (int i = 0; i < kErrors; ++i) {
    const Vector w = Vector::NullaryExpr(2, [&] { return normal(generator); });
    const NormalisedError result = normalised_error(B * w, P);
    ASSERT_TRUE(result.ok);
    ASSERT_EQ(result.dof, 2);
    nees[i] = result.value;
  }
  EXPECT_NEAR(nees.mean(), 2.0, 5.0 * 2.0 / std::sqrt(5000.0));
  EXPECT_NEAR((nees.array() - nees.mean()).square().sum() / (kErrors - 1), 4.0,
              5.0 * std::sqrt(8.0) * 4.0 / std::sqrt(5000.0));
}

}  // namespace
}  // namespace credence::internal
