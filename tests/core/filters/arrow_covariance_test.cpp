#include "core/filters/arrow_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

namespace credence::internal {
namespace {

/// A random positive definite arrow: a random P with its map made diagonal by adding to the blocks.
Matrix random_arrow(const BlockLayout& layout, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  const Index n = layout.state_dim(), nr = layout.vehicle, d = layout.landmark;
  Matrix P = Matrix::Zero(n, n);
  for (Index j = 0; j < layout.landmarks; ++j) {
    Matrix A(nr + d, nr + d);
    for (double& entry : A.reshaped()) entry = normal(bits);
    const Matrix two = A * A.transpose();
    const Index at = layout.landmark_offset(j);
    P.topLeftCorner(nr, nr) += two.topLeftCorner(nr, nr);
    P.block(0, at, nr, d) = two.topRightCorner(nr, d);
    P.block(at, 0, d, nr) = two.bottomLeftCorner(d, nr);
    P.block(at, at, d, d) = two.bottomRightCorner(d, d);
  }
  P.topLeftCorner(nr, nr) += Matrix::Identity(nr, nr);
  return P;
}

Vector random_vector(Index n, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  Vector v(n);
  for (double& x : v) x = normal(bits);
  return v;
}

TEST(ArrowCovariance, IsTheDenseMatrixThatItWasMadeOf) {
  for (const Index nr : {1, 3}) {
    for (const Index d : {1, 2}) {
      for (const Index N : {0, 1, 7, 8, 9, 33}) {
        const BlockLayout layout{.vehicle = nr, .landmark = d, .landmarks = N};
        const Matrix P = random_arrow(layout, 3);
        const ArrowCovariance arrow = ArrowCovariance::of(P, layout);
        EXPECT_TRUE(arrow.dense() == P);
        EXPECT_NEAR(arrow.trace(), P.trace(), 1e-13 * P.trace());
        for (Index i = 0; i < P.rows(); ++i) EXPECT_EQ(arrow.variance(i), P(i, i));
      }
    }
  }
}

TEST(ArrowCovariance, NeesIsThatOfTheDenseMatrix) {
  for (const Index nr : {1, 3}) {
    for (const Index d : {1, 2}) {
      const BlockLayout layout{.vehicle = nr, .landmark = d, .landmarks = 20};
      const Matrix P = random_arrow(layout, 5);
      const Vector e = random_vector(layout.state_dim(), 6);
      const ArrowCovariance arrow = ArrowCovariance::of(P, layout);
      const ArrowNees nees = arrow_nees(e, arrow);
      ASSERT_TRUE(nees.positive_definite);
      const double expected = e.dot(P.llt().solve(e));
      EXPECT_NEAR(nees.nees, expected, 1e-12 * expected);
      EXPECT_EQ(nees.dof, layout.state_dim());
    }
  }
}

TEST(ArrowCovariance, StatesWithoutVarianceAreNoDegreesOfFreedom) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  Matrix P = random_arrow(layout, 8);
  for (const Index i : {Index{1}, Index{6}}) {
    P.row(i).setZero();
    P.col(i).setZero();
  }
  Vector e = random_vector(11, 9);
  const ArrowNees nees = arrow_nees(e, ArrowCovariance::of(P, layout));
  P(1, 1) = P(6, 6) = 1.0;
  e[1] = e[6] = 0.0;
  const double expected = e.dot(P.llt().solve(e));
  ASSERT_TRUE(nees.positive_definite);
  EXPECT_EQ(nees.dof, 9);
  EXPECT_NEAR(nees.nees, expected, 1e-12 * expected);
}

TEST(ArrowCovariance, WhatIsNotPositiveDefiniteIsSaidToBe) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  const Matrix P = random_arrow(layout, 8);
  const Vector e = random_vector(11, 9);
  Matrix block = P;
  block(5, 5) = -1.0;
  EXPECT_FALSE(arrow_nees(e, ArrowCovariance::of(block, layout)).positive_definite);
  Matrix vehicle = P;
  vehicle(2, 2) = -1.0;
  EXPECT_FALSE(arrow_nees(e, ArrowCovariance::of(vehicle, layout)).positive_definite);
  // Every block is positive definite, the whole is not: the correlation of landmark 0 is too large.
  Matrix whole = P;
  whole.block(0, 3, 3, 2) *= 30.0;
  whole.block(3, 0, 2, 3) *= 30.0;
  EXPECT_FALSE(arrow_nees(e, ArrowCovariance::of(whole, layout)).positive_definite);
}

TEST(ArrowCovariance, SizesThatDoNotMatchAreRefused) {
  EXPECT_THROW(ArrowCovariance(4, 2), std::invalid_argument);
  EXPECT_THROW(ArrowCovariance(3, 3), std::invalid_argument);
  EXPECT_THROW(ArrowCovariance::of(Matrix::Identity(4, 4), {.vehicle = 3, .landmark = 2, .landmarks = 1}),
               std::invalid_argument);
  EXPECT_THROW(arrow_nees(Vector::Zero(4), ArrowCovariance(3, 2)), std::invalid_argument);
}

TEST(ArrowCovariance, TakesMemoryInProportionToTheMap) {
  ArrowCovariance P(3, 2);
  P.reserve(100000);
  EXPECT_LE(P.stride(), 100008);
}

}  // namespace
}  // namespace credence::internal
