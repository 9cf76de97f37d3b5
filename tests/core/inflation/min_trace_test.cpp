#include "core/inflation/min_trace.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/inflation/pairwise_bound.h"
#include "core/inflation/rank_one_bound.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Matrix low_rank_covariance(Index n, Index rank, unsigned seed) {
  const Matrix root = random_matrix(n, rank, seed);
  return root * root.transpose();
}

Vector eigenvalues(const Matrix& M) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(M, Eigen::EigenvaluesOnly).eigenvalues();
}

double pairwise_trace(Matrix A, const BlockLayout& layout) {
  const double before = A.trace();
  decorrelate_pairwise(A, layout);
  return A.trace() - before;
}

BlockLayout map_of(Index d, Index landmarks) { return {.vehicle = 0, .landmark = d, .landmarks = landmarks}; }

/// ΔP = E − offdiag(A).
Matrix inflation_of(const MinTraceBound& bound, const Matrix& A, const BlockLayout& layout) {
  Matrix delta = bound.E - A;
  const auto keep = [&](Index offset, Index size) {
    delta.block(offset, offset, size, size) = bound.E.block(offset, offset, size, size);
  };
  keep(0, layout.vehicle);
  for (Index j = 0; j < layout.landmarks; ++j) keep(layout.landmark_offset(j), layout.landmark);
  return delta;
}

/// What every bound must be, converged or not.
void expect_feasible(const MinTraceBound& bound, const Matrix& A, const BlockLayout& layout) {
  EXPECT_EQ(bound.primal, bound.E.trace());
  EXPECT_TRUE(bound.E == bound.E.transpose());
  EXPECT_GE(eigenvalues(inflation_of(bound, A, layout))(0), -1e-14 * bound.primal);
  EXPECT_LE(bound.primal, pairwise_trace(A, layout) * (1.0 + 1e-13));
  EXPECT_LE(bound.dual, bound.primal * (1.0 + 1e-14));
}

TEST(MinTrace, RandomCovariancesConvergeWithACertificate) {
  for (const BlockLayout& layout :
       {map_of(1, 2), map_of(1, 3), map_of(1, 10), map_of(2, 2), map_of(2, 3), map_of(2, 10), map_of(3, 5),
        map_of(4, 3), BlockLayout{.vehicle = 1, .landmark = 1, .landmarks = 10},
        BlockLayout{.vehicle = 3, .landmark = 2, .landmarks = 1},
        BlockLayout{.vehicle = 3, .landmark = 2, .landmarks = 10},
        BlockLayout{.vehicle = 6, .landmark = 3, .landmarks = 4}}) {
    const Index n = layout.state_dim();
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const Matrix A = low_rank_covariance(n, n, seed);
      const MinTraceBound bound = min_trace_bound(A, layout);
      EXPECT_TRUE(bound.converged);
      EXPECT_LT(bound.relative_gap, 1e-9) << "n = " << n << ", seed " << seed;
      expect_feasible(bound, A, layout);
      // Complementary slackness: the kernel of ΔP has at least the dimension of the widest block.
      const Vector spectrum = eigenvalues(inflation_of(bound, A, layout));
      const Index kernel = (spectrum.array() < 1e-8 * spectrum(n - 1)).count();
      EXPECT_GE(kernel, std::max(layout.vehicle, layout.landmark)) << "n = " << n << ", seed " << seed;
    }
  }
}

TEST(MinTrace, ThreeEqualNegativeCorrelationsByHand) {
  // O = I − 11ᵀ: the dual vectors stand 120° apart, E = I and ΔP = 11ᵀ; the pairwise sum gives 6.
  const Matrix A = Matrix::Identity(3, 3) - Matrix::Constant(3, 3, 1.0);
  const MinTraceBound bound = min_trace_bound(A, map_of(1, 3));
  EXPECT_NEAR(bound.primal, 3.0, 3e-10);
  EXPECT_NEAR(bound.dual, 3.0, 3e-10);
  EXPECT_TRUE(bound.E.isApprox(Matrix::Identity(3, 3), 1e-9));
  EXPECT_NEAR(pairwise_trace(A, map_of(1, 3)), 6.0, 1e-15);
}

TEST(MinTrace, TwoBlocksAreTheClosedForm) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 1};
  const Matrix A = low_rank_covariance(5, 5, 3);
  const MinTraceBound bound = min_trace_bound(A, layout);
  Matrix closed = A;
  closed.topLeftCorner(3, 3).setZero();
  closed.bottomRightCorner(2, 2).setZero();
  decorrelate_pairwise(closed, layout);
  EXPECT_TRUE(bound.E.topLeftCorner(3, 3).isApprox(closed.topLeftCorner(3, 3), 1e-10));
  EXPECT_TRUE(bound.E.bottomRightCorner(2, 2).isApprox(closed.bottomRightCorner(2, 2), 1e-10));
  EXPECT_NEAR(bound.primal, closed.trace(), 1e-10 * closed.trace());
}

TEST(MinTrace, PositiveScalarsAreThePairwiseBound) {
  const Matrix A = low_rank_covariance(12, 12, 4).cwiseAbs();
  const MinTraceBound bound = min_trace_bound(A, map_of(1, 12));
  EXPECT_NEAR(bound.primal, pairwise_trace(A, map_of(1, 12)), 1e-12 * bound.primal);
  // ΔP is a graph Laplacian: the common mode is free.
  EXPECT_LT((inflation_of(bound, A, map_of(1, 12)) * Vector::Ones(12)).cwiseAbs().maxCoeff(),
            1e-10 * bound.primal);
}

TEST(MinTrace, RankOneReductionsAreTheClosedForm) {
  for (Index d : {1, 2, 3}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      Vector l = random_matrix(8 * d, 1, seed);
      // Every second case has one landmark that outweighs all others together.
      if (seed % 2 == 0) l.segment(3 * d, d) *= 2.0 * l.lpNorm<1>() / l.segment(3 * d, d).norm();
      const MinTraceBound bound = min_trace_bound(-l * l.transpose(), map_of(d, 8));
      const ReductionBound closed = rank_one_bound(l, d);
      Matrix blocks = Matrix::Zero(d, 8 * d);
      reduce_and_inflate(closed, l, d, blocks);
      for (Index j = 0; j < 8; ++j) {
        blocks.middleCols(j * d, d) += l.segment(j * d, d) * l.segment(j * d, d).transpose();
      }
      double trace = 0.0;
      for (Index j = 0; j < 8; ++j) trace += blocks.middleCols(j * d, d).trace();
      EXPECT_EQ(closed.distinguished, seed % 2 == 0 ? 3 : -1);
      EXPECT_NEAR(bound.primal, trace, 1e-9 * trace) << "d = " << d << ", seed " << seed;
      EXPECT_LT(bound.relative_gap, 1e-9);
      for (Index j = 0; j < 8; ++j) {
        EXPECT_LT((bound.E.block(j * d, j * d, d, d) - blocks.middleCols(j * d, d)).norm(), 1e-4 * trace);
      }
    }
  }
}

TEST(MinTrace, NothingCorrelatedCostsNothing) {
  for (const Matrix& A : {Matrix(Matrix::Identity(6, 6)), Matrix(Matrix::Zero(6, 6))}) {
    const MinTraceBound bound = min_trace_bound(A, map_of(2, 3));
    EXPECT_TRUE(bound.converged);
    EXPECT_TRUE(bound.E.isZero(0.0));
    EXPECT_EQ(bound.primal, 0.0);
    EXPECT_EQ(bound.relative_gap, 0.0);
  }
  const MinTraceBound one_block = min_trace_bound(low_rank_covariance(3, 3, 1), map_of(3, 1));
  EXPECT_TRUE(one_block.E.isZero(0.0));
  EXPECT_TRUE(one_block.converged);
  EXPECT_TRUE(min_trace_bound(Matrix(0, 0), map_of(2, 0)).converged);
}

TEST(MinTrace, IsolatedBlocksGetNothing) {
  Matrix A = low_rank_covariance(8, 8, 6);
  A.row(5).setZero();
  A.col(5).setZero();
  A.row(4).setZero();
  A.col(4).setZero();
  const MinTraceBound bound = min_trace_bound(A, map_of(2, 4));
  EXPECT_LT(bound.relative_gap, 1e-9);
  EXPECT_LT(bound.E.block(4, 4, 2, 2).norm(), 1e-9 * bound.primal);
  expect_feasible(bound, A, map_of(2, 4));
}

TEST(MinTrace, SingularCovariances) {
  for (Index rank : {1, 2, 3}) {
    for (const BlockLayout& layout : {map_of(2, 6), map_of(1, 9), BlockLayout{3, 2, 5}}) {
      const Matrix A = low_rank_covariance(layout.state_dim(), rank, 5);
      const MinTraceBound bound = min_trace_bound(A, layout);
      EXPECT_LT(bound.relative_gap, 1e-9) << "rank " << rank;
      expect_feasible(bound, A, layout);
    }
  }
}

TEST(MinTrace, UnitsOfVeryDifferentSize) {
  // Headings in rad beside positions in metres, landmarks near and far: the scale of rows spans 1e8.
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 6};
  Vector scale = Vector::Ones(15);
  scale(2) = 1e-4;
  scale.tail(4).setConstant(1e4);
  scale.segment(5, 2).setConstant(1e-3);
  const Matrix A = scale.asDiagonal() * low_rank_covariance(15, 15, 8) * scale.asDiagonal();
  const MinTraceBound bound = min_trace_bound(A, layout);
  EXPECT_LT(bound.relative_gap, 1e-9);
  expect_feasible(bound, A, layout);
}

TEST(MinTrace, ExtremeMagnitudes) {
  const Matrix A = low_rank_covariance(8, 8, 9);
  const MinTraceBound bound = min_trace_bound(A, map_of(2, 4));
  for (double unit : {std::ldexp(1.0, 600), std::ldexp(1.0, -600)}) {
    const MinTraceBound scaled = min_trace_bound(unit * A, map_of(2, 4));
    EXPECT_EQ(scaled.primal, unit * bound.primal);
    EXPECT_EQ(scaled.dual, unit * bound.dual);
  }
}

TEST(MinTrace, NotFiniteIsDataNotAnException) {
  Matrix A = low_rank_covariance(6, 6, 1);
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    A(4, 1) = A(1, 4) = bad;
    const MinTraceBound bound = min_trace_bound(A, map_of(2, 3));
    EXPECT_FALSE(bound.converged);
    EXPECT_TRUE(std::isnan(bound.primal));
  }
}

/// Rank one at the very balance, a_i = L (1 + 1e-9): strict complementarity all but fails, the ascent crawls.
Matrix crawling_case() {
  Vector l = random_matrix(12, 1, 13);
  l(0) = l.tail(11).lpNorm<1>() * (1.0 + 1e-9);
  return -l * l.transpose();
}

TEST(MinTrace, FinishesByInteriorPointWhereTheAscentCrawls) {
  const Matrix A = crawling_case();
  const MinTraceBound bound = min_trace_bound(A, map_of(1, 12));
  EXPECT_GT(bound.interior_point_steps, 0);
  EXPECT_TRUE(bound.converged);
  EXPECT_LT(bound.relative_gap, 1e-9);
  expect_feasible(bound, A, map_of(1, 12));
}

TEST(MinTrace, GivingUpEarlyIsSaidAndStillFeasible) {
  const Matrix A = crawling_case();
  const MinTraceBound exact = min_trace_bound(A, map_of(1, 12));
  const MinTraceBound early =
      min_trace_bound(A, map_of(1, 12), {.max_sweeps = 5, .max_interior_point_dim = 0});
  EXPECT_FALSE(early.converged);
  EXPECT_EQ(early.interior_point_steps, 0);
  expect_feasible(early, A, map_of(1, 12));
  // The certificate is honest: the true minimum lies between what it claims.
  EXPECT_LE(early.dual, exact.primal);
  EXPECT_GE(early.primal, exact.dual);
}

TEST(MinTrace, IsNeverAboveThePairwiseBoundHoweverEarlyItStops) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Matrix A = low_rank_covariance(12, 12, seed).cwiseAbs();
    const MinTraceBound bound =
        min_trace_bound(A, map_of(1, 12), {.max_sweeps = 1, .max_interior_point_dim = 0});
    EXPECT_NEAR(bound.primal, pairwise_trace(A, map_of(1, 12)), 1e-13 * bound.primal);
    EXPECT_LT(bound.dual, bound.primal);
  }
}

TEST(MinTrace, InteriorPointAndAscentAgree) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Matrix A = low_rank_covariance(11, 11, seed);
    const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
    const MinTraceBound ascent =
        min_trace_bound(A, layout, {.max_sweeps = 20000, .max_interior_point_dim = 0});
    const MinTraceBound inside = min_trace_bound(A, layout, {.max_sweeps = 1});
    EXPECT_EQ(ascent.interior_point_steps, 0);
    EXPECT_GT(inside.interior_point_steps, 0);
    EXPECT_NEAR(ascent.primal, inside.primal, 1e-9 * ascent.primal);
    EXPECT_LT((ascent.E - inside.E).norm(), 1e-4 * ascent.primal);
  }
}

TEST(MinTrace, WarmStartSavesSweepsAndFollowsAGrowingMap) {
  const Matrix A = low_rank_covariance(23, 40, 21);
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 10};
  MinTraceState state;
  const MinTraceBound cold = min_trace_bound(A, layout, {}, &state);
  const MinTraceBound warm = min_trace_bound(A, layout, {}, &state);
  EXPECT_LE(warm.sweeps, 2);
  EXPECT_LT(warm.sweeps, cold.sweeps);
  EXPECT_NEAR(warm.primal, cold.primal, 2e-10 * cold.primal);

  MinTraceState growing;
  for (Index landmarks = 1; landmarks <= 10; ++landmarks) {
    const BlockLayout part{.vehicle = 3, .landmark = 2, .landmarks = landmarks};
    const Index n = part.state_dim();
    const MinTraceBound bound = min_trace_bound(A.topLeftCorner(n, n), part, {}, &growing);
    EXPECT_LT(bound.relative_gap, 1e-9);
    expect_feasible(bound, A.topLeftCorner(n, n), part);
  }
  // A state of another problem is not an error: the start is cold again.
  const MinTraceBound other = min_trace_bound(A.topLeftCorner(9, 9), map_of(3, 3), {}, &growing);
  EXPECT_LT(other.relative_gap, 1e-9);
}

TEST(MinTrace, OrderOfTheLandmarksDoesNotMatter) {
  const Matrix A = low_rank_covariance(10, 10, 31);
  Matrix reversed(10, 10);
  for (Index i = 0; i < 5; ++i) {
    for (Index j = 0; j < 5; ++j) reversed.block<2, 2>(2 * i, 2 * j) = A.block<2, 2>(8 - 2 * i, 8 - 2 * j);
  }
  const MinTraceBound one = min_trace_bound(A, map_of(2, 5)), other = min_trace_bound(reversed, map_of(2, 5));
  EXPECT_NEAR(one.primal, other.primal, 2e-10 * one.primal);
}

TEST(MinTrace, DecorrelatesInPlaceWithExactZeros) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  const Matrix P = low_rank_covariance(11, 11, 2);
  Matrix D = P;
  const MinTraceBound bound = decorrelate_min_trace(D, layout);
  EXPECT_LT((D - P - inflation_of(bound, P, layout)).cwiseAbs().maxCoeff(), 1e-14 * D.trace());
  for (Index i = 0; i < 11; ++i) {
    for (Index j = 0; j < 11; ++j) {
      const bool same = (i < 3 && j < 3) || (i >= 3 && j >= 3 && (i - 3) / 2 == (j - 3) / 2);
      if (!same) {
        EXPECT_EQ(D(i, j), 0.0);
      }
    }
  }
}

TEST(MinTrace, RejectsImpossibleInput) {
  const Matrix A = Matrix::Identity(4, 4);
  EXPECT_THROW(min_trace_bound(A, map_of(2, 3)), std::invalid_argument);
  EXPECT_THROW(min_trace_bound(A, map_of(2, 2), {.relative_gap = 0.0}), std::invalid_argument);
  EXPECT_THROW(min_trace_bound(A, map_of(2, 2), {.relative_gap = 1.0}), std::invalid_argument);
  EXPECT_THROW(min_trace_bound(A, map_of(2, 2), {.max_sweeps = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
