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

/// l_j l_jᵀ of every landmark, side by side.
Matrix squares_of(const Vector& l, Index d) {
  Matrix squares(d, l.size());
  for (Index j = 0; j < l.size(); j += d) {
    squares.middleCols(j, d) = l.segment(j, d) * l.segment(j, d).transpose();
  }
  return squares;
}

/// E: what is left of the reduction, and the reduction.
Matrix bound_of(const ReductionBound& bound, const Vector& l, Index d) {
  Matrix blocks = Matrix::Zero(d, l.size());
  reduce_and_inflate(bound, l, d, blocks);
  return block_diagonal(blocks + squares_of(l, d), d);
}

/// The least eigenvalue of ΔP = E − offdiag(−l lᵀ).
double least_eigenvalue_of_inflation(const Matrix& E, const Vector& l, Index d) {
  const Matrix delta = E + l * l.transpose() - block_diagonal(squares_of(l, d), d);
  return Eigen::SelfAdjointEigenSolver<Matrix>(delta, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

TEST(RankOneBound, ScalarsByHand) {
  // a = (1, 5, 2): L = 3 < 5, so e = (1 + 1·2, 5·3, 4 + 2·2); kept (5 − 3)² = 30 − 26.
  const Vector l{{1.0, -5.0, 2.0}};
  const ReductionBound bound = rank_one_bound(l, 1);
  EXPECT_EQ(bound.distinguished, 1);
  EXPECT_TRUE(bound_of(bound, l, 1).diagonal().isApprox(Vector{{3.0, 15.0, 8.0}}, 1e-15));
}

TEST(RankOneBound, DropsTheReductionWhenNoLandmarkDominates) {
  const Vector l{{1.0, -3.0, 2.0}};  // 3 = 1 + 2, the boundary
  const ReductionBound bound = rank_one_bound(l, 1);
  EXPECT_EQ(bound.distinguished, -1);
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
  EXPECT_DOUBLE_EQ(rank_one_bound(l, 1).t, 3e-12);
}

TEST(ReduceAndInflate, AddsToWhatIsThereSymmetrically) {
  for (Index d : {1, 2, 3}) {
    Vector l = random_matrix(5 * d, 1, 6);
    l.segment(d, d) *= 10.0;
    const Matrix root = random_matrix(d, 5 * d, 7);
    Matrix start(d, 5 * d);
    for (Index j = 0; j < 5 * d; j += d) {
      const Matrix square = root.middleCols(j, d) * root.middleCols(j, d).transpose();
      start.middleCols(j, d) = square.selfadjointView<Eigen::Lower>();
    }
    const ReductionBound bound = rank_one_bound(l, d);
    ASSERT_EQ(bound.distinguished, 1);
    Matrix D = start;
    reduce_and_inflate(bound, l, d, D);
    const Matrix E = bound_of(bound, l, d), squares = squares_of(l, d);
    for (Index j = 0; j < 5 * d; j += d) {
      const Matrix wanted = start.middleCols(j, d) + E.block(j, j, d, d) - squares.middleCols(j, d);
      EXPECT_LT((D.middleCols(j, d) - wanted).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_TRUE(D.middleCols(j, d) == D.middleCols(j, d).transpose());
    }
  }
}

TEST(ReductionBoundErrors, NameWhatIsWrong) {
  const Vector l = Vector::Ones(5);
  Matrix blocks = Matrix::Zero(2, 4);
  EXPECT_THROW(rank_one_bound(l, 2), std::invalid_argument);
  EXPECT_THROW(rank_one_bound(l, 0), std::invalid_argument);
  EXPECT_THROW(reduce_and_inflate({}, l, 1, blocks), std::invalid_argument);
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
