#include "analysis/tuning/maximise.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "tests/analysis/tuning/quadratic_score.h"

namespace credence::internal {
namespace {

using testing::QuadraticScore;
using testing::scales_of;
using testing::some_curvature;

const SearchBox kWideBox{Vector::Constant(3, -20.0), Vector::Constant(3, 20.0)};
const std::vector<bool> kAllFree{true, true, true};

TEST(Maximise, FindsTheTopOfAParabola) {
  const Vector top{{1.5, -2.0, 3.0}};
  for (const bool gradient : {true, false}) {
    const QuadraticScore score(top, some_curvature(), gradient);
    const Maximum found = maximise(score, Vector::Zero(3), kWideBox, kAllFree, scales_of(some_curvature()));
    ASSERT_TRUE(found.ok);
    // The value is off by the square of what phi is.
    EXPECT_NEAR(found.value, 0.0, 1e-4) << gradient;
    EXPECT_LT(((found.phi - top).cwiseQuotient(scales_of(some_curvature()))).norm(), 0.05) << gradient;
    EXPECT_EQ(found.value, score.highest()) << "the best point that was seen";
    EXPECT_EQ(found.value, score.scores(found.phi, false).sum());
  }
}

/// One whose scores cannot be had beyond some evaluations.
class FailingScore : public QuadraticScore {
 public:
  explicit FailingScore(bool gradient)
      : QuadraticScore(Vector{{1.5, -2.0, 3.0}}, some_curvature(), gradient) {}
  UnitScores scores(const Vector& phi, bool gradient) const override {
    if (evaluations() == 4) throw std::out_of_range("the fifth");
    return QuadraticScore::scores(phi, gradient);
  }
};

TEST(Maximise, WhatTheModelThrowsEndsTheSearchAsItIs) {
  for (const bool gradient : {true, false}) {
    const FailingScore score(gradient);
    try {
      maximise(score, Vector::Zero(3), kWideBox, kAllFree, scales_of(some_curvature()));
      FAIL() << gradient;
    } catch (const std::out_of_range& error) {
      EXPECT_STREQ(error.what(), "the fifth");
    }
    EXPECT_EQ(score.evaluations(), 4) << "none after it";
  }
}

TEST(Maximise, HoldsWhatIsNotFree) {
  const Matrix A = some_curvature();
  const Vector top{{1.5, -2.0, 3.0}}, start{{0.5, 0.25, -1.0}};
  for (const bool gradient : {true, false}) {
    const QuadraticScore score(top, A, gradient);
    const Maximum found = maximise(score, start, kWideBox, {false, true, false}, scales_of(A));
    EXPECT_EQ(found.phi[0], start[0]);
    EXPECT_EQ(found.phi[2], start[2]);
    // A_11 (φ_1 − top_1) = −A_10 (φ_0 − top_0) − A_12 (φ_2 − top_2).
    EXPECT_NEAR(found.phi[1], -2.0 - (12.0 * -1.0 + 1.0 * -4.0) / 9.0, 1e-3) << gradient;
    const Maximum none = maximise(score, start, kWideBox, {false, false, false}, scales_of(A));
    EXPECT_EQ(none.phi, start);
    EXPECT_EQ(none.value, score.scores(start, false).sum());
  }
}

TEST(Maximise, StaysWithinItsBounds) {
  // Scales of one, so that what the search works in is φ itself.
  const Matrix I = Matrix::Identity(3, 3);
  const SearchBox box{Vector::Constant(3, -2.0), Vector::Constant(3, 2.0)};
  for (const bool gradient : {true, false}) {
    const QuadraticScore score(Vector{{5.0, 0.5, -7.0}}, I, gradient);
    const Maximum found = maximise(score, Vector::Zero(3), box, kAllFree, Vector::Ones(3));
    EXPECT_EQ(found.phi[0], 2.0) << gradient;
    EXPECT_NEAR(found.phi[1], 0.5, 2e-3) << gradient;
    EXPECT_EQ(found.phi[2], -2.0) << gradient;
  }
}

TEST(Maximise, GoesRoundPointsWithoutScores) {
  for (const bool gradient : {true, false}) {
    const QuadraticScore score(Vector{{1.0, 1.0, 1.0}}, some_curvature(), gradient, 4.0);
    const Maximum found =
        maximise(score, Vector::Constant(3, -3.0), kWideBox, kAllFree, scales_of(some_curvature()));
    ASSERT_TRUE(found.ok);
    EXPECT_NEAR(found.value, 0.0, 1e-3) << gradient;
    const Maximum nothing =
        maximise(score, Vector::Constant(3, 5.0), kWideBox, kAllFree, scales_of(some_curvature()));
    EXPECT_FALSE(nothing.ok);
  }
}

// A wall beside the top, on the way to which the search meets it from everywhere.
TEST(Maximise, FindsATopBesidePointsWithoutScores) {
  for (const double start : {-3.0, -1.0, 0.0, 0.8}) {
    const QuadraticScore score(Vector{{1.0, 1.0, 1.0}}, some_curvature(), false, 1.02);
    const Maximum found =
        maximise(score, Vector::Constant(3, start), kWideBox, kAllFree, scales_of(some_curvature()));
    ASSERT_TRUE(found.ok);
    EXPECT_NEAR(found.value, 0.0, 0.02) << start;
  }
}

TEST(Maximise, RefusesAStartOutsideItsBounds) {
  const QuadraticScore score(Vector::Zero(3), some_curvature());
  for (const double out : {-20.5, 20.5}) {
    EXPECT_THROW(maximise(score, Vector{{0.0, out, 0.0}}, kWideBox, kAllFree, Vector::Ones(3)),
                 std::invalid_argument);
  }
  EXPECT_EQ(score.evaluations(), 0);
}

TEST(Maximise, NeverLeavesItsBoundsByRounding) {
  const double end = std::log(1e6);
  const SearchBox box{Vector::Constant(2, -end), Vector::Constant(2, end)};
  for (int i = 1; i < 200; ++i) {
    const Vector scale = Vector::Constant(2, 1.0 / std::sqrt(3.7 * i));
    const QuadraticScore score(Vector{{20.0, -20.0}}, 3.7 * i * Matrix::Identity(2, 2));
    const Maximum found = maximise(score, Vector::Zero(2), box, {true, true}, scale);
    EXPECT_LE(found.phi[0], end) << i;
    EXPECT_GE(found.phi[1], -end) << i;
  }
}

}  // namespace
}  // namespace credence::internal
