#include "core/linear_algebra/inverse_root.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/linear_algebra/decompositions.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Vector product(InverseRoot& root, const Vector& x) {
  Vector u = x;
  root.multiply(u.data());
  return u;
}

/// Positive definite, of unit diagonal.
Matrix correlation(Index n, std::uint64_t seed, double regular = 0.1) {
  const Matrix A = random_matrix(n, n, seed);
  const Matrix P = A * A.transpose() + regular * Matrix::Identity(n, n);
  const Vector scale = P.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * P * scale.asDiagonal();
}

TEST(InverseRoot, IsThatOfTheEigenvalues) {
  InverseRoot root;
  for (Index n = 1; n <= 60; ++n) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Matrix R = correlation(n, seed);
      const Vector x = random_matrix(n, 1, seed + 10);
      const Eigen::SelfAdjointEigenSolver<Matrix> eigen(R);
      const Vector expected = eigen.operatorInverseSqrt() * x;
      ASSERT_TRUE(root.compute(n, R.data())) << n;
      const double condition = eigen.eigenvalues()[n - 1] / eigen.eigenvalues()[0];
      EXPECT_LT((product(root, x) - expected).norm(),
                1e-15 * static_cast<double>(n) * condition * expected.norm())
          << n << " of seed " << seed;
    }
  }
}

// (1 ± ρ)^{-1/2} along (1, ±1)/√2.
TEST(InverseRoot, OfTwoRowsIsTheFormula) {
  InverseRoot root;
  for (const double rho : {0.0, 0.3, -0.9, 0.999999}) {
    const Matrix R{{1.0, rho}, {rho, 1.0}};
    ASSERT_TRUE(root.compute(2, R.data()));
    const Vector u = product(root, Vector{{3.0, 1.0}});
    const double sum = 4.0 / std::sqrt(1.0 + rho), difference = 2.0 / std::sqrt(1.0 - rho);
    EXPECT_NEAR(u[0], 0.5 * (sum + difference), 1e-15 * difference) << rho;
    EXPECT_NEAR(u[1], 0.5 * (sum - difference), 1e-15 * difference) << rho;
  }
}

// Of numbers that are all correlated alike: (1 + 2ρ)^{-1/2} along (1, 1, 1), (1 − ρ)^{-1/2} across it. One
// eigenvalue is small near ρ = −½, two near 1.
TEST(InverseRoot, OfThreeRowsIsTheFormula) {
  InverseRoot root;
  for (const double rho : {0.0, 1e-9, 0.3, -0.3, -0.4999999, 0.9999999}) {
    Matrix R = Matrix::Constant(3, 3, rho);
    R.diagonal().setOnes();
    ASSERT_TRUE(root.compute(3, R.data())) << rho;
    const Vector u = product(root, Vector{{3.0, 1.0, -1.0}});
    const double along = 1.0 / std::sqrt(1.0 + 2.0 * rho), across = 1.0 / std::sqrt(1.0 - rho);
    const double rounding = 1e-15 * std::pow(std::max(along, across), 3.0);
    EXPECT_NEAR(u[0], along + 2.0 * across, rounding) << rho;
    EXPECT_NEAR(u[1], along, rounding) << rho;
    EXPECT_NEAR(u[2], along - 2.0 * across, rounding) << rho;
  }
}

// Three groups of a matrix of each kind of algorithm, whose rows are mixed: what is zero stays zero.
TEST(InverseRoot, KeepsGroupsApart) {
  for (const Index size : {2, 3, 5}) {
    const Index n = 3 * size;
    Matrix R = Matrix::Identity(n, n);
    for (Index group = 0; group < 3; ++group) {
      const Matrix part = correlation(size, static_cast<std::uint64_t>(group + 1));
      for (Index i = 0; i < size; ++i) {
        for (Index j = 0; j < size; ++j) R(3 * i + group, 3 * j + group) = part(i, j);
      }
    }
    InverseRoot root;
    ASSERT_TRUE(root.compute(n, R.data()));
    Vector x = Vector::Zero(n);
    x[3] = 1.0;
    const Vector u = product(root, x);
    for (Index i = 0; i < n; ++i) {
      if (i % 3 != 0) EXPECT_NEAR(u[i], 0.0, 1e-15) << i;
    }
    EXPECT_NEAR(u.squaredNorm(), R.inverse()(3, 3), 1e-12 * u.squaredNorm());
  }
}

TEST(InverseRoot, RefusesWhatIsSingular) {
  InverseRoot root;
  for (const Index n : {2, 3, 4, 7, 15}) {
    Matrix R = correlation(n, 1);
    ASSERT_TRUE(root.compute(n, R.data()));
    R.row(1) = R.row(0);
    R.col(1) = R.col(0);
    R(1, 1) = 1.0;
    EXPECT_FALSE(root.compute(n, R.data())) << n;
    R(0, 1) = R(1, 0) = 1.5;
    EXPECT_FALSE(root.compute(n, R.data())) << n;
    R = correlation(n, 2);
    EXPECT_TRUE(root.compute(n, R.data())) << n;
  }
}

}  // namespace
}  // namespace credence::internal
