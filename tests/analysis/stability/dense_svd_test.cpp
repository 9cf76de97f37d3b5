#include "analysis/stability/dense_svd.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::random_matrix;

struct SvdShape {
  Index rows, cols;
};
constexpr SvdShape kSvdShapes[] = {{5, 3}, {3, 5}, {4, 4}, {1, 6}, {6, 1}, {40, 25}};

double away_from_orthonormal(const Matrix& basis) {
  return (basis.transpose() * basis - Matrix::Identity(basis.cols(), basis.cols())).norm();
}

TEST(DenseSvd, GivesTheSideThatIsAskedFor) {
  std::mt19937_64 generator(1);
  for (const auto& [rows, cols] : kSvdShapes) {
    const Matrix M = random_matrix(rows, cols, generator);
    const Index least = std::min(rows, cols);
    const DenseSvd none = dense_svd(M), left = dense_svd(M, SvdVectors::left),
                   right = dense_svd(M, SvdVectors::right);
    EXPECT_EQ(none.U.size() + none.V.size() + left.V.size() + right.U.size(), 0);
    ASSERT_EQ(left.U.cols(), least);
    ASSERT_EQ(right.V.cols(), least);
    EXPECT_LT(away_from_orthonormal(left.U) + away_from_orthonormal(right.V), 1e-12);
    for (const DenseSvd& svd : {none, left, right}) {
      ASSERT_EQ(svd.s.size(), least);
      for (Index i = 1; i < least; ++i) EXPECT_GE(svd.s[i - 1], svd.s[i]);
      EXPECT_GE(svd.s[least - 1], 0.0);
      EXPECT_NEAR(svd.s.squaredNorm(), M.squaredNorm(), 1e-12 * M.squaredNorm());
    }
    // M Mᵀ = U s² Uᵀ and Mᵀ M = V s² Vᵀ.
    const Matrix squares = left.s.cwiseAbs2().asDiagonal();
    EXPECT_LT((left.U * squares * left.U.transpose() - M * M.transpose()).norm(), 1e-11 * M.squaredNorm());
    EXPECT_LT((right.V * squares * right.V.transpose() - M.transpose() * M).norm(), 1e-11 * M.squaredNorm());
  }
}

TEST(DenseSvd, CompletesToASquare) {
  std::mt19937_64 generator(2);
  for (const auto& [rows, cols] : kSvdShapes) {
    const Matrix M = random_matrix(rows, cols, generator);
    const DenseSvd left = dense_svd(M, SvdVectors::full_left), right = dense_svd(M, SvdVectors::full_right);
    ASSERT_EQ(left.U.cols(), rows);
    ASSERT_EQ(right.V.cols(), cols);
    EXPECT_LT(away_from_orthonormal(left.U) + away_from_orthonormal(right.V), 1e-12);
    const Index least = std::min(rows, cols);
    EXPECT_LT((M.transpose() * left.U.rightCols(rows - least)).norm(), 1e-12 * M.norm());
    EXPECT_LT((M * right.V.rightCols(cols - least)).norm(), 1e-12 * M.norm());
  }
}

TEST(DenseSvd, KnowsTheSingularValuesOfKnownMatrices) {
  Matrix M(2, 2);
  M << 3.0, 0.0, 4.0, 5.0;  // √45 and √5
  const Vector s = dense_svd(M).s;
  EXPECT_NEAR(s[0], std::sqrt(45.0), 1e-14);
  EXPECT_NEAR(s[1], std::sqrt(5.0), 1e-14);
  const Vector rank_one = dense_svd(Vector{{1.0, 2.0, 2.0}} * Vector{{3.0, 4.0}}.transpose()).s;
  EXPECT_NEAR(rank_one[0], 15.0, 1e-13);
  EXPECT_NEAR(rank_one[1], 0.0, 1e-13);
  EXPECT_EQ(dense_svd(Matrix::Zero(3, 2)).s, Vector::Zero(2));
}

TEST(DenseSvd, OfNoRowsOrNoColumnsHasFullBases) {
  for (const auto& [rows, cols] : {SvdShape{0, 3}, {3, 0}, {0, 0}}) {
    const Matrix M(rows, cols);
    for (const SvdVectors vectors : {SvdVectors::none, SvdVectors::left, SvdVectors::right,
                                     SvdVectors::full_left, SvdVectors::full_right}) {
      const DenseSvd svd = dense_svd(M, vectors);
      EXPECT_EQ(svd.s.size(), 0);
      EXPECT_EQ(svd.U.cols(), vectors == SvdVectors::full_left ? rows : 0);
      EXPECT_EQ(svd.V.cols(), vectors == SvdVectors::full_right ? cols : 0);
    }
    EXPECT_EQ(dense_svd(M, SvdVectors::left).U.rows(), rows);
    EXPECT_EQ(dense_svd(M, SvdVectors::right).V.rows(), cols);
    EXPECT_EQ(dense_svd(M, SvdVectors::full_right).V, Matrix::Identity(cols, cols));
  }
}

}  // namespace
}  // namespace credence::internal
