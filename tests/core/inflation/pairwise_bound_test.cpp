#include "core/inflation/pairwise_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <stdexcept>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// (M Mᵀ)^{1/2} by the textbook: the check is independent of the closed forms under test.
Matrix modulus(const Matrix& M) {
  const Eigen::JacobiSVD<Matrix> svd(M, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return svd.matrixU() * svd.singularValues().asDiagonal() * svd.matrixU().transpose();
}

double smallest_eigenvalue(const Matrix& M) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(M, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

/// Decorrelates by the definition: every pair, textbook square roots.
Matrix decorrelated_by_definition(const Matrix& A, const BlockLayout& layout) {
  const auto offset = [&](Index b) { return b == 0 ? Index{0} : layout.landmark_offset(b - 1); };
  const auto size = [&](Index b) { return b == 0 ? layout.vehicle : layout.landmark; };
  Matrix D = Matrix::Zero(A.rows(), A.cols());
  for (Index j = 0; j <= layout.landmarks; ++j) {
    if (size(j) == 0) continue;
    auto block = D.block(offset(j), offset(j), size(j), size(j));
    block = A.block(offset(j), offset(j), size(j), size(j));
    for (Index k = 0; k <= layout.landmarks; ++k) {
      if (k != j && size(k) > 0) block += modulus(A.block(offset(j), offset(k), size(j), size(k)));
    }
  }
  return D;
}

/// Of two blocks whose correlation is C: what each of them gets.
Matrix bound_of_two(const Matrix& C) {
  const Index n = C.rows(), d = C.cols();
  Matrix A = Matrix::Zero(n + d, n + d);
  A.topRightCorner(n, d) = C;
  A.bottomLeftCorner(d, n) = C.transpose();
  decorrelate_pairwise(A, {.vehicle = n, .landmark = d, .landmarks = 1});
  return A;
}

TEST(DecorrelatePairwise, ScalarsAndDiagonalsByHand) {
  EXPECT_EQ(bound_of_two(Matrix::Constant(1, 1, -3.0)), 3.0 * Matrix::Identity(2, 2));
  Matrix C(2, 2);
  C << 0.0, 2.0, -5.0, 0.0;
  EXPECT_TRUE(bound_of_two(C).isApprox(Vector{{2.0, 5.0, 5.0, 2.0}}.asDiagonal().toDenseMatrix(), 1e-15));
}

TEST(DecorrelatePairwise, AddedTraceOfTwoBlocksIsTwiceTheNuclearNorm) {
  for (const auto& [rows, cols] : {std::pair<Index, Index>{3, 2}, {2, 3}, {4, 1}, {1, 4}, {5, 5}}) {
    const Matrix C = random_matrix(rows, cols, 7);
    Matrix joint = bound_of_two(C);
    EXPECT_NEAR(joint.trace(), 2.0 * Eigen::JacobiSVD<Matrix>(C).singularValues().sum(), 1e-13);
    joint.topRightCorner(rows, cols) = -C;
    joint.bottomLeftCorner(cols, rows) = -C.transpose();
    EXPECT_GE(smallest_eigenvalue(joint), -1e-14);
  }
}

constexpr BlockLayout kLayouts[] = {
    {.vehicle = 1, .landmark = 1, .landmarks = 5}, {.vehicle = 0, .landmark = 1, .landmarks = 5},
    {.vehicle = 3, .landmark = 2, .landmarks = 4}, {.vehicle = 0, .landmark = 2, .landmarks = 4},
    {.vehicle = 2, .landmark = 2, .landmarks = 3}, {.vehicle = 6, .landmark = 3, .landmarks = 3},
    {.vehicle = 3, .landmark = 1, .landmarks = 4}, {.vehicle = 1, .landmark = 2, .landmarks = 3},
    {.vehicle = 2, .landmark = 5, .landmarks = 2}, {.vehicle = 4, .landmark = 2, .landmarks = 0}};

TEST(DecorrelatePairwise, FollowsTheDefinitionForEveryShape) {
  for (const BlockLayout& layout : kLayouts) {
    const Index n = layout.state_dim();
    for (Index rank : {n, Index{1}, Index{2}}) {
      const Matrix root = random_matrix(n, rank, 11);
      Matrix A = root * root.transpose();
      const Matrix expected = decorrelated_by_definition(A, layout);
      decorrelate_pairwise(A, layout);
      EXPECT_LT((A - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.trace())
          << "vehicle " << layout.vehicle << " landmark " << layout.landmark << " rank " << rank;
    }
  }
}

TEST(DecorrelatePairwise, KeepsTheSmallSingularValueOfANearlySingularBlock) {
  // σ = 2 and 5e-13 by construction; a square root of C Cᵀ would leave 5e-13 lost below 1e-8.
  Eigen::Matrix2d U, V;
  U << 0.6, -0.8, 0.8, 0.6;
  V << 0.28, 0.96, -0.96, 0.28;
  const Eigen::Vector2d sigma(2.0, 5e-13);
  Matrix A = Matrix::Zero(4, 4);
  A.bottomLeftCorner(2, 2) = U * sigma.asDiagonal() * V.transpose();
  A.topRightCorner(2, 2) = A.bottomLeftCorner(2, 2).transpose();
  decorrelate_pairwise(A, {.vehicle = 0, .landmark = 2, .landmarks = 2});
  EXPECT_NEAR(A(2, 2) + A(3, 3), 2.0 + 5e-13, 1e-15);
  EXPECT_NEAR(U.col(1).dot(A.bottomRightCorner(2, 2) * U.col(1)), 5e-13, 5e-16);
}

TEST(DecorrelatePairwise, PowersOfTwoScaleExactly) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  const Matrix root = random_matrix(11, 11, 2);
  Matrix A = root * root.transpose(), B = std::ldexp(1.0, 40) * A;
  decorrelate_pairwise(A, layout);
  decorrelate_pairwise(B, layout);
  EXPECT_TRUE(B == std::ldexp(1.0, 40) * A);
}

TEST(DecorrelatePairwise, UncorrelatedStaysAsItIs) {
  Matrix A = Matrix::Identity(7, 7);
  decorrelate_pairwise(A, {.vehicle = 3, .landmark = 2, .landmarks = 2});
  EXPECT_TRUE(A == Matrix::Identity(7, 7));
}

TEST(DecorrelatePairwise, RejectsALayoutOfAnotherSize) {
  Matrix A = Matrix::Identity(4, 4);
  EXPECT_THROW(decorrelate_pairwise(A, {.vehicle = 3, .landmark = 2, .landmarks = 1}), std::invalid_argument);
  EXPECT_THROW(decorrelate_pairwise(A, {.vehicle = 6, .landmark = 2, .landmarks = -1}),
               std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
