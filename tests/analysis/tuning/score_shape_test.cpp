#include "analysis/tuning/score_shape.h"

#include <gmock/gmock.h>

#include <cmath>

#include "analysis/stability/exact_moments.h"
#include "core/filters/linear_filter.h"
#include "tests/analysis/tuning/local_level.h"
#include "tests/analysis/tuning/other_methods.h"

namespace credence::internal {
namespace {

using testing::local_level;
using testing::simulate;

class LocalLevelRidge : public ::testing::Test {
 protected:
  // Values in φ are logarithms of factors on the truth.
  LocalLevelRidge()
      : score_({local_level(0.1, 1.0), parse_free_noise("diag(Q),diag(R)")},
               simulate(local_level(0.1, 1.0), 20, 5000, 3)),
        tuning_(tune(score_, Vector::Zero(2))) {}

  LinearScore score_;
  Tuning tuning_;
};

/// A whole curve of wrong pairs has E[NIS] = 1, and only the correlation of the innovations tells.
TEST_F(LocalLevelRidge, IsThatOfTheKnownPairs) {
  struct Pair {
    double q, r, lag_one;
  };
  for (const Pair& pair : {Pair{0.005, 1.97, 0.47},
                           {0.01, 1.59, 0.34},
                           {0.03, 1.24, 0.17},
                           {0.3, 0.78, -0.15},
                           {1.0, 0.41, -0.34}}) {
    const double shift = std::log(pair.q / 0.1) - tuning_.phi[0];
    const auto ridge = nis_ridge(score_, tuning_, 0, 1, {shift});
    ASSERT_EQ(ridge.size(), 1U) << pair.q;
    // NIS over 100,000 steps is known to 1.4 % at five standard errors of white ones, r to as much of its
    // part.
    EXPECT_NEAR(std::exp(ridge.front().phi[1]) / pair.r, 1.0, 0.06) << pair.q;
    EXPECT_NEAR(ridge.front().lag_one, pair.lag_one, 0.02) << pair.q;
    EXPECT_GT(ridge.front().drop, 100.0) << "the score tells them apart";
  }
}

TEST_F(LocalLevelRidge, TuningByNisAloneEndsOnItAndOursDoesNot) {
  double farthest = 0.0;
  for (const Vector& start :
       {Vector{{-2.0, 0.0}}, Vector{{2.0, 0.0}}, Vector{{0.0, 2.0}}, Vector{{0.0, -2.0}}}) {
    const Vector phi = testing::tune_by_nis(score_, start);
    EXPECT_NEAR(score_.scores(phi, false).mean_nis(), 1.0, 1e-3) << "a perfect NIS";
    farthest = std::max(farthest, std::abs(phi[0]));
    const Tuning ours = tune(score_, start);
    EXPECT_NEAR(ours.phi[0], 0.0, 0.15) << "five standard errors of 100,000 steps";
    EXPECT_NEAR(ours.phi[1], 0.0, 0.05);
  }
  EXPECT_GT(farthest, 1.0) << "and a process noise that is wrong by e or more";
}

/// At (0.3, 0.78) the exact means of NIS and NEES are within 6 % of a right filter.
TEST(Ridge, NeesHasOneToo) {
  const LinearModel truth = local_level(0.1, 1.0), wrong = local_level(0.3, 0.78);
  const ExactMoments last = exact_moments(truth, linear_filter_steps(wrong, {}, 500)).back();
  EXPECT_NEAR(last.nis, 1.0, 0.01);
  EXPECT_NEAR(last.nees, 1.0, 0.06);
}

TEST_F(LocalLevelRidge, ProfileIsAParabolaAtItsTop) {
  const ScoreProfile profile = score_profile(score_, tuning_, 0, 5, 1.0);
  ASSERT_EQ(profile.drop.size(), 5U);
  // One standard error away it falls by a half.
  EXPECT_NEAR(profile.drop.front(), 0.5, 0.05);
  EXPECT_NEAR(profile.drop[2], 0.0, 1e-3);
  EXPECT_NEAR(profile.drop.back(), 0.5, 0.05);
}

TEST_F(LocalLevelRidge, SurfaceIsHighestAtTheTuning) {
  const ScoreSurface surface = score_surface(score_, tuning_, 0, 1, 1.0, 5);
  EXPECT_NEAR(surface.drop(2, 2), 0.0, 1e-12);
  EXPECT_GE(surface.drop.minCoeff(), -1e-12);
  EXPECT_GT(surface.drop(0, 0), 1e-3);
}

}  // namespace
}  // namespace credence::internal
