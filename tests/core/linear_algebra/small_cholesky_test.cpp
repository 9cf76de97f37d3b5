#include "core/linear_algebra/small_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Matrix positive_definite(Index n, std::uint64_t seed) {
  const Matrix A = random_matrix(n, n, seed);
  return A * A.transpose() + 0.1 * Matrix::Identity(n, n);
}

TEST(SmallCholesky, has_the_bits_of_eigen_at_every_size) {
  SmallCholesky small;
  for (Index n = 1; n <= SmallCholesky::kMost; ++n) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Matrix P = positive_definite(n, seed);
      const Eigen::LLT<Matrix> llt(P);
      ASSERT_TRUE(small.compute(P)) << n;
      ASSERT_EQ(small.size(), n);
      const Matrix expected = llt.matrixL(), L = small.lower().triangularView<Eigen::Lower>();
      EXPECT_EQ(L, expected) << n << " of seed " << seed;
      EXPECT_EQ(small.pivot(n - 1), expected(n - 1, n - 1));
      Vector x = random_matrix(n, 1, seed + 7), y = x;
      if (n > 2) x[n / 2] = y[n / 2] = 0.0;
      llt.matrixL().solveInPlace(x);
      small.solve_lower(y);
      EXPECT_EQ(y, x) << n << " of seed " << seed;
      Vector diagonal;
      small.inverse_diagonal(diagonal);
      const Vector inverse = llt.solve(Matrix::Identity(n, n)).diagonal();
      EXPECT_LT((diagonal - inverse).cwiseQuotient(inverse).cwiseAbs().maxCoeff(), 1e-10) << n;
    }
  }
}

TEST(SmallCholesky, reads_the_lower_triangle_of_a_block) {
  Matrix large = random_matrix(9, 9, 3);
  const Matrix P = positive_definite(4, 2);
  large.block(3, 2, 4, 4) = P;
  large.block(3, 2, 4, 4).triangularView<Eigen::StrictlyUpper>().setConstant(17.0);
  SmallCholesky whole, of_block;
  ASSERT_TRUE(whole.compute(P));
  ASSERT_TRUE(of_block.compute(large.block(3, 2, 4, 4)));
  EXPECT_EQ(Matrix(of_block.lower().triangularView<Eigen::Lower>()),
            Matrix(whole.lower().triangularView<Eigen::Lower>()));
}

TEST(SmallCholesky, refuses_what_has_no_factor) {
  SmallCholesky small;
  Matrix P = positive_definite(3, 1);
  P(1, 1) = -1.0;
  EXPECT_FALSE(small.compute(P));
  EXPECT_FALSE(small.compute(Matrix::Zero(2, 2)));
  EXPECT_FALSE(small.compute(Matrix::Ones(2, 2)));  // its second pivot is zero
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Matrix on = Matrix::Identity(3, 3), off = on;
    on(2, 2) = bad;
    off(2, 0) = bad;
    EXPECT_FALSE(small.compute(on));
    EXPECT_FALSE(small.compute(off));
  }
  EXPECT_TRUE(small.compute(Matrix::Identity(3, 3)));
}

TEST(SmallCholesky, of_nothing_is_nothing) {
  SmallCholesky small;
  EXPECT_TRUE(small.compute(Matrix(0, 0)));
  Vector none(0);
  small.solve_lower(none);
  EXPECT_EQ(small.size(), 0);
}

}  // namespace
}  // namespace credence::internal
