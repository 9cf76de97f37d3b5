#include "core/inflation/rank_one_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>
#include <stdexcept>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Matrix block_diagonal(const Matrix& blocks, Index d) {
  Matrix D = Matrix::Zero(blocks.cols(), blocks.cols());
  for (Index j = 0; j < blocks.cols(); j += d) D.block(j, j, d, d) = blocks.middleCols(j, d);
  return D;
}

Matrix bound_of(const ReductionBound& bound, const Matrix& L, Index d) {
  Matrix blocks = Matrix::Zero(d, L.rows());
  add_bound(bound, L, d, blocks);
  return block_diagonal(blocks, d);
}

/// The least eigenvalue of ΔP = E − offdiag(−L Lᵀ).
double least_eigenvalue_of_inflation(const Matrix& E, const Matrix& L, Index d) {
  Matrix squares(d, L.rows());
  for (Index j = 0; j < L.rows(); j += d) {
    squares.middleCols(j, d) = L.middleRows(j, d) * L.middleRows(j, d).transpose();
  }
  const Matrix delta = E + L * L.transpose() - block_diagonal(squares, d);
  return Eigen::SelfAdjointEigenSolver<Matrix>(delta, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

TEST(RankOneBound, ScalarsByHand) {
  // a = (1, 5, 2): L = 3 < 5, so e = (1 + 1·2, 5·3, 4 + 2·2); kept (5 − 3)² = 30 − 26.
  const Vector l{{1.0, -5.0, 2.0}};
  const ReductionBound bound = rank_one_bound(l, 1);
  EXPECT_EQ(bound.distinguished, 1);
  EXPECT_DOUBLE_EQ(bound.weight(0, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(bound.weight(1, 5.0), 15.0);
  EXPECT_DOUBLE_EQ(bound.weight(2, 2.0), 8.0);
  EXPECT_DOUBLE_EQ(bound_of(bound, l, 1).trace(), 26.0);
}

TEST(RankOneBound, DropsTheReductionWhenNoLandmarkDominates) {
  const Vector l{{1.0, -3.0, 2.0}};  // 3 = 1 + 2, the boundary
  const ReductionBound bound = rank_one_bound(l, 1);
  EXPECT_EQ(bound.distinguished, -1);
  EXPECT_DOUBLE_EQ(bound.weight(1, 3.0), 9.0);
  Matrix blocks = Matrix::Constant(1, 3, 7.0);
  reduce_and_inflate(bound, l, 1, blocks);
  EXPECT_TRUE(blocks == Matrix::Constant(1, 3, 7.0));
}

TEST(RankOneBound, ALoneLandmarkKeepsItsWholeReduction) {
  Vector l = Vector::Zero(8);
  l.segment(4, 2) << 0.3, -0.4;
  const ReductionBound bound = rank_one_bound(l, 2);
  EXPECT_EQ(bound.distinguished, 2);
  EXPECT_TRUE(bound_of(bound, l, 2).isZero(0.0));
  EXPECT_TRUE(bound_of(rank_one_bound(Vector::Zero(8), 2), Vector::Zero(8), 2).isZero(0.0));
  EXPECT_EQ(rank_one_bound(Vector(0), 2).distinguished, -1);
}

TEST(RankOneBound, IsPsdAndKeepsTheTraceOfTheTheory) {
  for (Index d : {1, 2, 3}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Vector l = random_matrix(6 * d, 1, seed);
      l.segment(2 * d, d) *= static_cast<double>(seed);
      const ReductionBound bound = rank_one_bound(l, d);
      const Matrix E = bound_of(bound, l, d);
      EXPECT_GE(least_eigenvalue_of_inflation(E, l, d), -1e-14 * l.squaredNorm());
      double largest = 0.0, sum = 0.0;
      for (Index j = 0; j < 6; ++j) {
        const double a = l.segment(j * d, d).norm();
        largest = std::max(largest, a);
        sum += a;
      }
      const double kept = std::pow(std::max(0.0, largest - (sum - largest)), 2);
      EXPECT_NEAR(l.squaredNorm() - E.trace(), kept, 1e-13 * l.squaredNorm());
    }
  }
}

TEST(RankOneBound, ATinyRestIsNotLostBesideAHugeLandmark) {
  // L = 3e-12 beside 1: subtracting the largest from the sum of all would leave four digits of it.
  const Vector l{{1e-12, 1.0, 2e-12}};
  EXPECT_DOUBLE_EQ(rank_one_bound(l, 1).weight(1, 1.0), 3e-12);
}

TEST(LowRankBound, IsPsdForEveryT) {
  for (Index columns : {1, 2, 4}) {
    const Matrix L = random_matrix(10, columns, 3);
    for (double t : {1e-3, 0.1, 0.5, 0.9, 1.0}) {
      const Matrix E = bound_of(low_rank_bound(L, 2, 4, t), L, 2);
      EXPECT_GE(least_eigenvalue_of_inflation(E, L, 2), -1e-14 * E.trace()) << columns << ", t = " << t;
    }
  }
}

TEST(LowRankBound, HasItsLeastTraceWhereTheTheorySays) {
  Matrix L = random_matrix(10, 2, 4);
  L.middleRows(4, 2) *= 20.0;
  const ReductionBound best = low_rank_bound(L, 2, 2);
  EXPECT_LT(best.t, 1.0);
  const double least = bound_of(best, L, 2).trace();
  for (double factor : {0.5, 0.9, 0.99, 1.01, 1.1, 1.5}) {
    if (factor * best.t <= 1.0) {
      EXPECT_GT(bound_of(low_rank_bound(L, 2, 2, factor * best.t), L, 2).trace(), least);
    }
  }
  EXPECT_NEAR(bound_of(low_rank_bound(L, 2, 2, best.t), L, 2).trace(), least, 1e-13 * least);
  // A landmark that does not dominate: t = 1, all dropped.
  EXPECT_EQ(low_rank_bound(L, 2, 0).t, 1.0);
  EXPECT_EQ(low_rank_bound(L, 2, 0).excess, 0.0);
}

TEST(LowRankBound, OneColumnIsTheExactBound) {
  Vector l = random_matrix(12, 1, 5);
  l.segment(6, 2) *= 30.0;
  const ReductionBound exact = rank_one_bound(l, 2), low = low_rank_bound(l, 2, 3);
  EXPECT_EQ(low.distinguished, exact.distinguished);
  EXPECT_DOUBLE_EQ(low.t, exact.t);
  EXPECT_DOUBLE_EQ(low.excess, exact.excess);
}

TEST(ReduceAndInflate, IsTheReductionPlusTheBound) {
  for (Index d : {1, 2, 3}) {
    Matrix L = random_matrix(5 * d, 2, 6);
    L.middleRows(d, d) *= 10.0;
    const Matrix before = random_matrix(d, 5 * d, 7);
    Matrix D = before;
    for (Index j = 0; j < 5; ++j) {
      auto block = D.middleCols(j * d, d);
      block = (block * block.transpose()).eval();
      for (Index a = 0; a < d; ++a) {
        for (Index b = 0; b < a; ++b) block(b, a) = block(a, b);
      }
    }
    const Matrix start = D;
    const ReductionBound bound = low_rank_bound(L, d, 1);
    reduce_and_inflate(bound, L, d, D);
    const Matrix expected = block_diagonal(start, d) + bound_of(bound, L, d);
    for (Index j = 0; j < 5; ++j) {
      const Matrix rows = L.middleRows(j * d, d);
      const Matrix wanted = expected.block(j * d, j * d, d, d) - rows * rows.transpose();
      EXPECT_LT((D.middleCols(j * d, d) - wanted).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_TRUE(D.middleCols(j * d, d) == D.middleCols(j * d, d).transpose());
    }
  }
}

TEST(ReductionBoundErrors, NameWhatIsWrong) {
  const Vector l = Vector::Ones(5);
  Matrix blocks = Matrix::Zero(2, 4);
  EXPECT_THROW(rank_one_bound(l, 2), std::invalid_argument);
  EXPECT_THROW(rank_one_bound(l, 0), std::invalid_argument);
  EXPECT_THROW(low_rank_bound(l, 1, 5), std::invalid_argument);
  EXPECT_THROW(low_rank_bound(l, 1, 0, 0.0), std::invalid_argument);
  EXPECT_THROW(low_rank_bound(l, 1, 0, 1.5), std::invalid_argument);
  EXPECT_THROW(add_bound(drop_bound(), l, 1, blocks), std::invalid_argument);
}

TEST(RankOneBound, WhatLowersTheTraceLowersItAsStored) {
  // One landmark hardly outweighs the others: rounding may raise the stored trace, but none that counts.
  std::mt19937_64 bits(3);
  std::uniform_real_distribution<double> uniform(0.5, 1.5), exponent(-16.0, 0.0);
  const auto sum = [](const Matrix& blocks) { return blocks.cast<long double>().sum(); };
  int counted = 0, rose_uncounted = 0;
  for (int i = 0; i < 20'000; ++i) {
    Matrix blocks(1, 5);
    Vector l(5);
    const double size = std::pow(10.0, 0.25 * exponent(bits));
    for (Index j = 0; j < 5; ++j) {
      blocks(0, j) = uniform(bits);
      l[j] = 0.2 * size * uniform(bits);
    }
    l[0] = l.tail(4).sum() * (1.0 + std::pow(10.0, exponent(bits)));
    const ReductionBound bound = rank_one_bound(l, 1);
    const Matrix before = blocks;
    reduce_and_inflate(bound, l, 1, blocks);
    const bool rose = sum(blocks) > sum(before);
    if (lowers_trace(bound.excess, before.sum())) {
      ++counted;
      EXPECT_FALSE(rose) << bound.excess;
    } else {
      rose_uncounted += rose ? 1 : 0;
    }
  }
  EXPECT_GT(counted, 5000);
  EXPECT_GT(rose_uncounted, 100);  // it is not for nothing
}

}  // namespace
}  // namespace credence::internal
