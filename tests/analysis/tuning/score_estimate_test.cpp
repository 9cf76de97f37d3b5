#include "analysis/tuning/score_estimate.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/analysis/tuning/quadratic_score.h"

namespace credence::internal {
namespace {

using testing::QuadraticScore;
using testing::scales_of;
using testing::some_curvature;

const SearchBox kSearched{Vector::Constant(3, -20.0), Vector::Constant(3, 20.0)};
const Vector kTop{{1.5, -2.0, 3.0}};

TEST(ScoreEstimate, OfAParabolaIsItsTopAndItsCurvature) {
  const Matrix A = some_curvature();
  for (const bool gradient : {true, false}) {
    const QuadraticScore score(kTop, A, gradient);
    const ScoreEstimate e =
        estimate_score(score, Vector::Zero(3), kSearched, {true, true, true}, scales_of(A));
    ASSERT_TRUE(e.ok);
    EXPECT_LT(e.decrement, 1e-6);
    EXPECT_NEAR(e.value, 0.0, 1e-6);
    // (φ − top)ᵀ A (φ − top) is the decrement.
    EXPECT_NEAR((e.phi - kTop).dot(A * (e.phi - kTop)), e.decrement, 1e-9);
    EXPECT_LT((e.information - A).norm(), 1e-9 * A.norm());
    EXPECT_LT((e.covariance * A - Matrix::Identity(3, 3)).norm(), 1e-9);
    EXPECT_EQ(e.free, (std::vector<Index>{0, 1, 2}));
  }
}

TEST(ScoreEstimate, IsOfTheFreeCoordinates) {
  const Matrix A = some_curvature();
  const QuadraticScore score(kTop, A);
  const ScoreEstimate e =
      estimate_score(score, Vector::Zero(3), kSearched, {true, false, true}, scales_of(A));
  ASSERT_TRUE(e.ok);
  EXPECT_EQ(e.free, (std::vector<Index>{0, 2}));
  EXPECT_EQ(e.phi[1], 0.0);
  EXPECT_NEAR(e.information(0, 0), 40.0, 1e-7);
  EXPECT_NEAR(e.information(0, 1), -3.0, 1e-7);
  EXPECT_NEAR(e.information(1, 1), 2.0, 1e-7);
  // Σ g gᵀ of one unit between the inverses.
  const Vector move = e.covariance * e.unit_scores.col(0);
  EXPECT_LT((e.sandwich() - move * move.transpose()).norm(), 1e-12);
}

TEST(ScoreEstimate, HasNoCovarianceWhereItIsNotCurved) {
  Matrix flat = some_curvature();
  flat.row(2).setZero();
  flat.col(2).setZero();
  flat(2, 2) = -1e-9;
  const ScoreEstimate e = estimate_score(QuadraticScore(kTop, flat), Vector::Zero(3), kSearched,
                                         {true, true, true}, Vector::Ones(3));
  EXPECT_TRUE(e.ok);
  EXPECT_EQ(e.covariance.size(), 0);
  EXPECT_FALSE(estimate_score(QuadraticScore(kTop, flat, true, -1.0), Vector::Zero(3), kSearched,
                              {true, true, true}, Vector::Ones(3))
                   .ok);
}

TEST(ProfileScore, SeeksTheOthersAgain) {
  const Matrix A = some_curvature(), covariance = A.inverse();
  const QuadraticScore score(kTop, A);
  for (const double value : {-1.0, 0.0, 2.5}) {
    const Maximum there =
        profile_score(score, Vector::Zero(3), kSearched, {true, true, true}, scales_of(A), 0, value);
    EXPECT_EQ(there.phi[0], value);
    // The profile of a parabola is −½ (φ_0 − top_0)²/(A⁻¹)_00.
    EXPECT_NEAR(there.value, -0.5 * std::pow(value - 1.5, 2) / covariance(0, 0), 1e-4) << value;
  }
}

TEST(ProfileLimits, OfAParabolaLieASquareRootAway) {
  const Matrix A = some_curvature(), covariance = A.inverse();
  const QuadraticScore score(kTop, A);
  const ScoreEstimate e = estimate_score(score, Vector::Zero(3), kSearched, {true, true, true}, scales_of(A));
  for (const double drop : {0.5, 1.92}) {
    for (Index i = 0; i < 3; ++i) {
      const ProfileLimits limits =
          profile_limits(score, e, kSearched, {true, true, true}, scales_of(A), i, drop);
      const double reach = std::sqrt(2.0 * drop * covariance(i, i));
      EXPECT_NEAR(limits.lower, kTop[i] - reach, 2e-3) << i;
      EXPECT_NEAR(limits.upper, kTop[i] + reach, 2e-3) << i;
    }
  }
}

TEST(ProfileLimits, AreInfiniteWhereTheBoxEndsFirst) {
  const Matrix A = Matrix::Identity(2, 2);
  const QuadraticScore score(Vector::Zero(2), A);
  const SearchBox box{Vector{{-5.0, -1.0}}, Vector{{1.0, 5.0}}};
  const ScoreEstimate e = estimate_score(score, Vector::Zero(2), box, {true, true}, Vector::Ones(2));
  const auto of = [&](Index i) {
    return profile_limits(score, e, box, {true, true}, Vector::Ones(2), i, 2.0);
  };
  EXPECT_NEAR(of(0).lower, -2.0, 1e-3);
  EXPECT_EQ(of(0).upper, HUGE_VAL);
  EXPECT_EQ(of(1).lower, -HUGE_VAL);
  EXPECT_NEAR(of(1).upper, 2.0, 1e-3);
}

TEST(ProfileLimits, ATopOnTheUpperBoundHasNoUpperLimit) {
  const QuadraticScore score(Vector{{5.0, 0.0}}, Matrix::Identity(2, 2));
  const SearchBox box{Vector::Constant(2, -3.0), Vector::Constant(2, 3.0)};
  const ScoreEstimate e = estimate_score(score, Vector::Zero(2), box, {true, true}, Vector::Ones(2));
  EXPECT_EQ(profile_limits(score, e, box, {true, true}, Vector::Ones(2), 0, 1.0).upper, HUGE_VAL);
}

}  // namespace
}  // namespace credence::internal
