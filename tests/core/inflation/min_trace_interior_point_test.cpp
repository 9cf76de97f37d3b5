#include "core/inflation/min_trace_interior_point.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

constexpr double kGap = 1e-9;

double least_eigenvalue(const Matrix& M) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(M, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

std::vector<DiagonalBlock> blocks_of(std::initializer_list<Index> sizes) {
  std::vector<DiagonalBlock> blocks;
  Index offset = 0;
  for (const Index size : sizes) {
    blocks.push_back({offset, size});
    offset += size;
  }
  return blocks;
}

Matrix without_blocks(Matrix A, const std::vector<DiagonalBlock>& blocks) {
  for (const DiagonalBlock& b : blocks) A.block(b.offset, b.offset, b.size, b.size).setZero();
  return A;
}

/// An E with E − O ≻ 0.
Matrix dominating(const Matrix& O) {
  return (1.0 + O.cwiseAbs().rowwise().sum().maxCoeff()) * Matrix::Identity(O.rows(), O.cols());
}

TEST(MinTraceInteriorPoint, EndsWithACertificateOfItsOptimum) {
  // ⟨O, X⟩ <= tr E for every feasible pair: one whose gap is nothing cannot be improved.
  const std::vector<DiagonalBlock> blocks = blocks_of({3, 2, 2, 1, 2});
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const Matrix A = random_matrix(10, 10, seed);
    const Matrix O = without_blocks(A + A.transpose(), blocks);
    const MinTraceInteriorPoint result = min_trace_interior_point(O, blocks, dominating(O), kGap);
    const double primal = result.E.trace(), dual = O.cwiseProduct(result.X).sum();
    EXPECT_GE(primal, dual);
    EXPECT_LE(primal - dual, 2.0 * kGap * primal);
    EXPECT_GE(least_eigenvalue(result.E - O), 0.0);
    EXPECT_GE(least_eigenvalue(result.X), 0.0);
    EXPECT_EQ(without_blocks(result.E, blocks), Matrix(Matrix::Zero(10, 10)))
        << "E has blocks and nothing else";
    for (const DiagonalBlock& b : blocks) {
      const Matrix own = result.X.block(b.offset, b.offset, b.size, b.size);
      EXPECT_LT((own - Matrix::Identity(b.size, b.size)).cwiseAbs().maxCoeff(), 1e-9);
    }
    EXPECT_LE(result.steps, 20);
  }
}

TEST(MinTraceInteriorPoint, TwoBlocksCostTwiceTheNuclearNorm) {
  // min tr E₁ + tr E₂ with [E₁ −B; −Bᵀ E₂] ⪰ 0 is 2 Σ σ(B).
  const std::vector<DiagonalBlock> blocks = blocks_of({3, 2});
  const Matrix B = random_matrix(3, 2, 8);
  Matrix O = Matrix::Zero(5, 5);
  O.topRightCorner(3, 2) = B;
  O.bottomLeftCorner(2, 3) = B.transpose();
  const double expected = 2.0 * Eigen::JacobiSVD<Matrix>(B).singularValues().sum();
  const Matrix E = min_trace_interior_point(O, blocks, dominating(O), kGap).E;
  EXPECT_NEAR(E.trace(), expected, 2.0 * kGap * expected);
}

TEST(MinTraceInteriorPoint, ThreeEqualCorrelationsByHand) {
  // O = a (1 1ᵀ − I): for a > 0 the largest eigenvalue is 2a, E = 2a I; for a < 0, E = |a| I.
  const std::vector<DiagonalBlock> blocks = blocks_of({1, 1, 1});
  const Matrix O = without_blocks(Matrix::Ones(3, 3), blocks);
  EXPECT_NEAR(min_trace_interior_point(O, blocks, dominating(O), kGap).E.trace(), 6.0, 1e-7);
  EXPECT_NEAR(min_trace_interior_point(-O, blocks, dominating(O), kGap).E.trace(), 3.0, 1e-7);
}

TEST(MinTraceInteriorPoint, GivesBackWhatCannotBeStartedFrom) {
  const std::vector<DiagonalBlock> blocks = blocks_of({1, 1});
  const Matrix O = without_blocks(Matrix::Ones(2, 2), blocks);
  const MinTraceInteriorPoint none = min_trace_interior_point(O, blocks, 0.5 * Matrix::Identity(2, 2), kGap);
  EXPECT_EQ(none.steps, 0);
  EXPECT_EQ(none.E, Matrix(0.5 * Matrix::Identity(2, 2)));
  EXPECT_EQ(none.X, Matrix(Matrix::Identity(2, 2)));
}

TEST(MinTraceInteriorPoint, DoesNoMoreThanTheGapAskedFor) {
  const std::vector<DiagonalBlock> blocks = blocks_of({2, 2, 2});
  const Matrix A = random_matrix(6, 6, 9), O = without_blocks(A + A.transpose(), blocks);
  const MinTraceInteriorPoint rough = min_trace_interior_point(O, blocks, dominating(O), 0.1);
  const MinTraceInteriorPoint fine = min_trace_interior_point(O, blocks, dominating(O), 1e-8);
  EXPECT_LT(rough.steps, fine.steps);
  EXPECT_LE((rough.E - O).cwiseProduct(rough.X).sum(), 0.1 * rough.E.trace());
  EXPECT_GT(rough.E.trace(), fine.E.trace());
}

}  // namespace
}  // namespace credence::internal
