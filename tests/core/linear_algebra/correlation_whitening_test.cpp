#include "core/linear_algebra/correlation_whitening.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Matrix covariance(Index n, std::uint64_t seed) {
  const Matrix A = random_matrix(n, n, seed);
  const Vector scale = random_matrix(n, 1, seed + 50).array().abs() + 0.1;
  return scale.asDiagonal() * (A * A.transpose() + 0.1 * Matrix::Identity(n, n)) * scale.asDiagonal();
}

Vector whitened(const Matrix& P, const Vector& error) {
  CorrelationWhitening whitening;
  EXPECT_TRUE(whitening.compute(P));
  Vector u;
  whitening.whiten(error, u);
  return u;
}

TEST(CorrelationWhitening, PermutedErrorsArePermutedAfterwards) {
  for (const Index n : {2, 3, 4, 5, 6, 7, 12, 24}) {
    const auto seed = static_cast<std::uint64_t>(n);
    const Matrix P = covariance(n, seed);
    const Vector e = random_matrix(n, 1, seed + 1), u = whitened(P, e);
    EXPECT_NEAR(u.squaredNorm(), e.dot(P.llt().solve(e)), 1e-10 * u.squaredNorm()) << n;
    std::vector<Index> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), Index{0});
    std::mt19937_64 bits(seed);
    for (int i = 0; i < 8; ++i) {
      std::ranges::shuffle(order, bits);
      const Vector permuted = whitened(P(order, order), e(order)), expected = u(order);
      EXPECT_LT((permuted - expected).norm(), 1e-11 * u.norm()) << n;
    }
  }
}

TEST(CorrelationWhitening, KnowsNoUnits) {
  for (const Index n : {4, 9}) {
    const Matrix P = covariance(n, 3);
    const Vector e = random_matrix(n, 1, 4), u = whitened(P, e);
    Vector by_two = Vector::Ones(n), by_thousand = Vector::Ones(n);
    for (Index i = 0; i < n; ++i) {
      by_two[i] = std::ldexp(1.0, static_cast<int>(3 * i) - 7);
      by_thousand[i] = i % 2 == 0 ? 1e3 : 1.0;
    }
    const auto in_units = [&](const Vector& unit) {
      return whitened(unit.asDiagonal() * P * unit.asDiagonal(), unit.cwiseProduct(e));
    };
    EXPECT_EQ(in_units(by_two), u);
    EXPECT_LT((in_units(by_thousand) - u).norm(), 1e-11 * u.norm());
  }
}

TEST(CorrelationWhitening, DividesUncorrelatedErrorsByTheirDeviations) {
  const Vector e{{3.0, -1.0, 2.0}};
  const Matrix P = Vector{{4.0, 1e-12, 1e12}}.asDiagonal();
  const Vector u = whitened(P, e);
  EXPECT_NEAR(u[0], 1.5, 1e-15);
  EXPECT_NEAR(u[1], -1e6, 1e-9);
  EXPECT_NEAR(u[2], 2e-6, 1e-20);
}

TEST(CorrelationWhitening, ReadsTheLowerTriangleOfABlock) {
  Matrix large = random_matrix(12, 12, 3);
  const Matrix P = covariance(7, 2);
  const Vector e = random_matrix(7, 1, 5);
  large.block(3, 2, 7, 7) = P;
  large.block(3, 2, 7, 7).triangularView<Eigen::StrictlyUpper>().setConstant(17.0);
  CorrelationWhitening whitening;
  ASSERT_TRUE(whitening.compute(large.block(3, 2, 7, 7)));
  Vector u;
  whitening.whiten(e, u);
  EXPECT_EQ(u, whitened(P, e));
}

TEST(CorrelationWhitening, HasNoTraceOfTheCovariancesBefore) {
  CorrelationWhitening whitening;
  Vector u;
  for (const Index n : {4, 4, 9, 3, 9}) {
    const Matrix P = covariance(n, 7);
    Matrix broken = P;
    broken(1, 1) = 0.0;
    EXPECT_FALSE(whitening.compute(broken));
    EXPECT_FALSE(whitening.compute(broken)) << "twice the same";
    broken(1, 1) = kNaN;
    EXPECT_FALSE(whitening.compute(broken));
    const Vector e = random_matrix(n, 1, 8);
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(whitening.compute(P));
      whitening.whiten(e, u);
      EXPECT_EQ(u, whitened(P, e));
    }
  }
  EXPECT_FALSE(whitening.compute(Matrix::Zero(2, 2)));
  EXPECT_FALSE(whitening.compute(Matrix(0, 0)));
}

}  // namespace
}  // namespace credence::internal
