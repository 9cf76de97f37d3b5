#include "core/inflation/batch_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "core/inflation/min_trace.h"
#include "core/inflation/rank_one_bound.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// A map of `measured` and then `others` landmarks whose last L_j are X_jᵀ G.
template <int r, int d>
struct Batch {
  Index measured, others;
  Matrix L, G;

  Batch(Index k, Index rest, Index scalars, std::uint64_t seed, double size_of_others = 1.0)
      : measured(k), others(rest), L(random_matrix(d * (k + rest), scalars, seed)) {
    G = random_matrix(r, scalars, seed + 1);
    L.bottomRows(d * rest) = size_of_others * random_matrix(d * rest, r, seed + 2) * G;
  }

  Index landmarks() const { return measured + others; }

  BatchBound<r, d> bound() const {
    const BatchBasis<r> Q = batch_basis<r>(G);
    BatchOthers<r> sums;
    for (Index j = measured; j < landmarks(); ++j) {
      sums.add(Eigen::Matrix<double, d, r>(L.middleRows<d>(d * j) * Q));
    }
    return batch_bound<r, d>(L.topRows(d * measured), Q, sums, 0.0);
  }

  /// What the bound adds to D.
  Matrix change(const BatchBound<r, d>& bound) const {
    const BatchBasis<r> Q = batch_basis<r>(G);
    Matrix change = Matrix::Zero(L.rows(), L.rows());
    for (Index j = 0; j < landmarks(); ++j) {
      auto block = change.block<d, d>(d * j, d * j);
      if (j < measured) {
        block = bound.changes.template middleCols<d>(d * j);
      } else {
        block = bound.growth(L.middleRows<d>(d * j) * Q);
      }
    }
    return change;
  }

  /// The least eigenvalue of what is left above D − L Lᵀ, over tr L Lᵀ.
  double least_eigenvalue(const BatchBound<r, d>& bound) const {
    const Matrix above = change(bound) + L * L.transpose();
    return Eigen::SelfAdjointEigenSolver<Matrix>(above, Eigen::EigenvaluesOnly).eigenvalues()(0) /
           L.squaredNorm();
  }

  /// By how much the exact least trace lowers the map.
  double exact_gain() const {
    const BlockLayout layout{.vehicle = 0, .landmark = d, .landmarks = landmarks()};
    return L.squaredNorm() - min_trace_bound(-L * L.transpose(), layout).dual;
  }
};

template <int r, int d>
void expect_valid_and_near_the_least_trace(double size_of_others, double least_share) {
  double gain = 0.0, exact = 0.0;
  int lowered = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Index k = 1 + static_cast<Index>(seed % 4), rest = static_cast<Index>(seed % 7);
    const Batch<r, d> batch(k, rest, d * k, 100 * seed, size_of_others);
    const BatchBound<r, d> bound = batch.bound();
    exact += batch.exact_gain();
    if (!bound.lowers) continue;
    ++lowered;
    gain += bound.gain;
    EXPECT_GT(batch.least_eigenvalue(bound), -1e-14) << "seed " << seed;
    EXPECT_NEAR(-batch.change(bound).trace(), bound.gain, 1e-12 * batch.L.squaredNorm()) << "seed " << seed;
    EXPECT_LE(bound.gain, batch.exact_gain() + 1e-8 * batch.L.squaredNorm()) << "seed " << seed;
  }
  EXPECT_GT(lowered, 20);
  EXPECT_GT(gain, least_share * exact);
}

TEST(BatchBound, IsABoundNearTheLeastTraceInThePlane) {
  expect_valid_and_near_the_least_trace<3, 2>(0.0, 0.97);
  expect_valid_and_near_the_least_trace<3, 2>(0.02, 0.85);
  expect_valid_and_near_the_least_trace<3, 2>(0.2, 0.6);
}

TEST(BatchBound, IsABoundNearTheLeastTraceOnTheLine) {
  expect_valid_and_near_the_least_trace<1, 1>(0.0, 0.9);
  expect_valid_and_near_the_least_trace<1, 1>(0.1, 0.6);
}

TEST(BatchBound, ALoneLandmarkMeasuredOnceHasTheBoundInClosedForm) {
  // One scalar, the landmark measured the largest: rank_one_bound is the exact least trace.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Batch<1, 1> batch(1, 5, 1, seed, 0.05);
    batch.L(0, 0) += 2.0;
    const ReductionBound exact = rank_one_bound(batch.L.col(0), 1);
    ASSERT_EQ(exact.distinguished, 0);
    const BatchBound<1, 1> bound = batch.bound();
    ASSERT_TRUE(bound.lowers);
    EXPECT_NEAR(bound.gain, exact.excess * exact.excess, 1e-10 * bound.gain);
    const Matrix change = batch.change(bound);
    for (Index j = 0; j < 6; ++j) {
      const double a = std::abs(batch.L(j, 0));
      EXPECT_NEAR(change(j, j), j == exact.distinguished ? (exact.t - 1.0) * a * a : exact.excess * a, 1e-9);
    }
  }
}

TEST(BatchBound, ALandmarkWithoutOthersKeepsItsWholeReduction) {
  const Batch<3, 2> batch(1, 0, 2, 5);
  const BatchBound<3, 2> bound = batch.bound();
  ASSERT_TRUE(bound.lowers);
  EXPECT_NEAR(bound.gain, batch.L.squaredNorm(), 2e-6 * batch.L.squaredNorm());
}

TEST(BatchBound, NothingIsGainedWhereOthersOutweighTheMeasured) {
  const Batch<3, 2> large(2, 6, 4, 7, 100.0);
  // Two landmarks are measured by four scalars, of which one is theirs alone: the rest is for all.
  const BatchBound<3, 2> bound = large.bound();
  if (bound.lowers) {
    EXPECT_GT(large.least_eigenvalue(bound), -1e-14);
  }
  const Batch<3, 2> one(1, 6, 2, 7, 100.0);
  EXPECT_FALSE(one.bound().lowers);
  const Batch<3, 2> none(0, 6, 2, 7);
  EXPECT_FALSE(none.bound().lowers);
}

TEST(BatchBound, DegenerateBatchesHaveABoundOrNone) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    for (int kind = 0; kind < 6; ++kind) {
      Batch<3, 2> batch(3, 3, 6, seed);
      auto measured = batch.L.topRows(6);
      if (kind == 0) measured.row(2) = measured.row(0);                    // two landmarks that move alike
      if (kind == 1) measured.bottomRows(4).setZero();                     // one that moves alone
      if (kind == 2) measured = measured.col(0) * measured.row(0).eval();  // one direction in all
      if (kind == 3) batch.L.setZero();
      if (kind == 4) batch.L *= 1e120;
      if (kind == 5) batch.L *= 1e-120;
      const BatchBound<3, 2> bound = batch.bound();
      if (!bound.lowers) continue;
      EXPECT_TRUE(bound.changes.allFinite() && bound.spread.allFinite()) << seed << ", kind " << kind;
      EXPECT_GT(batch.least_eigenvalue(bound), -1e-13) << seed << ", kind " << kind;
    }
  }
}

TEST(BatchBound, ANumberThatIsNoneHasNoBound) {
  Batch<3, 2> batch(2, 2, 4, 1);
  batch.L(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(batch.bound().lowers);
  batch.L(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(batch.bound().lowers);
}

TEST(BatchBound, AGainWithinTheRoundingOfTheMapIsNone) {
  const Batch<3, 2> batch(1, 0, 2, 5);
  const BatchBound<3, 2> bound =
      batch_bound<3, 2>(batch.L, batch_basis<3>(batch.G), {}, 1e15 * batch.L.squaredNorm());
  EXPECT_FALSE(bound.lowers);
}

TEST(BatchBound, TheBasisHoldsTheRowsOfG) {
  for (const Index scalars : {1, 2, 3, 4, 12}) {
    Matrix G = random_matrix(3, scalars, 3);
    if (scalars == 12) G.row(2) = 2.0 * G.row(0);
    const BatchBasis<3> Q = batch_basis<3>(G);
    EXPECT_LT((G - G * Q * Q.transpose()).norm(), 1e-14 * G.norm());
    const Matrix square = Q.transpose() * Q;
    for (Index i = 0; i < std::min<Index>(3, scalars); ++i) EXPECT_NEAR(square(i, i), 1.0, 1e-14);
  }
}

TEST(BatchBound, GroupsAreEvenAndNoneIsTooLarge) {
  EXPECT_EQ(batch_group(6), 6);
  EXPECT_EQ(batch_group(32), 32);
  EXPECT_EQ(batch_group(34), 18);
  EXPECT_EQ(batch_group(100), 26);
  for (Index scalars = 1; scalars < 200; ++scalars) EXPECT_LE(batch_group(scalars), kMostBatchScalars);
}

}  // namespace
}  // namespace credence::internal
