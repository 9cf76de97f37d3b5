#include "analysis/stability/planar_path.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "core/stop_point.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

/// Steps of 0.5 m once round a circle of 20 m, with everything in view.
Scenario scenario_of_circle(Index landmarks, Index anchors = 0) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = landmarks;
  s.world.anchors = anchors;
  s.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  s.world.speed = 1.0;
  s.world.dt = 0.5;
  s.world.path_radius = 20.0 / (2.0 * std::numbers::pi);
  s.world.sensor_range = 100.0;
  s.world.sensor_min_range = 0.0;
  s.noise.turn_rate_std = 0.02;
  s.filter.inflation = FilterInflation::none;
  return s;
}

TEST(PlanarStepsPerLoop, AreTheLengthOverTheStepRoundedUp) {
  Scenario s = scenario_of_circle(1);
  EXPECT_EQ(planar_steps_per_loop(s), 40);  // 20 m of 0.5 m
  s.world.dt = 0.1;
  s.world.path_radius = 5.8 / (2.0 * std::numbers::pi);
  EXPECT_EQ(planar_steps_per_loop(s), 58);  // rounding makes it 58 and 7e-15 more
  s = scenario_of_circle(1);
  s.world.speed = 0.99;
  EXPECT_EQ(planar_steps_per_loop(s), 41);
  s.world.speed = 2.0;
  s.world.path = PathShape::eight;  // two circles
  EXPECT_EQ(planar_steps_per_loop(s), 40);
  s.world.path = PathShape::line;  // forth and back
  s.world.path_radius = 2.6;
  EXPECT_EQ(planar_steps_per_loop(s), 11);  // 10.4 m
  s.world.speed = 1e9;
  EXPECT_EQ(planar_steps_per_loop(s), 1);
}

TEST(PlanarPathRun, OfTheTruthComesBackToWhereItBegan) {
  const PlanarPathRun run = follow_planar_path(scenario_of_circle(2, 1), 3, Linearisation::truth);
  ASSERT_TRUE(run.ok);
  EXPECT_EQ(run.traces.size(), 3U);
  EXPECT_EQ(run.not_converged, 0);
  EXPECT_TRUE(std::isnan(run.pose_nees));
  const PlanarLoopRecord& loop = run.loop;
  ASSERT_EQ(loop.F.size(), 40U);
  ASSERT_EQ(loop.H.size(), 41U);
  ASSERT_EQ(loop.K.size(), 40U);
  ASSERT_EQ(loop.process.size(), 40U);
  ASSERT_EQ(loop.inflation.size(), 40U);
  EXPECT_EQ(loop.start.size(), 7);
  // Turned by ψ at its beginning the loop ends where it would anyway: the moves across sum up to nothing.
  Matrix around = Matrix::Identity(7, 7);
  for (const Matrix& F : loop.F) around = (F * around).eval();
  EXPECT_LT((around - Matrix::Identity(7, 7)).norm(), 1e-9);
  // Without noise the estimate is the truth and the landmarks are those of the world.
  for (Index i = 0; i < 2; ++i) {
    double least = 1e9;
    for (const Point& landmark : run.world.landmarks)
      least = std::min(least, (loop.start.segment<2>(loop.layout.landmark_offset(i)) - landmark).norm());
    EXPECT_LT(least, 1e-9);
  }
}

TEST(PlanarPathRun, JacobiansAreThoseOfRangeAndBearing) {
  const PlanarPathRun run = follow_planar_path(scenario_of_circle(2, 1), 2, Linearisation::estimate);
  ASSERT_TRUE(run.ok);
  const PlanarLoopRecord& loop = run.loop;
  Index of_anchors = 0;
  for (std::size_t k = 1; k < loop.H.size(); ++k) {
    const Matrix& H = loop.H[k];
    ASSERT_EQ(H.rows(), 6);
    for (Index i = 0; i < H.rows(); i += 2) {
      // The range changes along a unit vector and not with the heading, the bearing across it, by 1/ρ.
      EXPECT_NEAR((H.block<1, 2>(i, 0).norm()), 1.0, 1e-12);
      EXPECT_EQ(H(i, 2), 0.0);
      EXPECT_EQ(H(i + 1, 2), -1.0);
      EXPECT_NEAR((H.block<1, 2>(i, 0).dot(H.block<1, 2>(i + 1, 0))), 0.0, 1e-12);
      // What moves a landmark of the state against the vehicle; an anchor has no columns.
      const Matrix sum = H.block(i, 0, 2, 2) + H.block(i, 3, 2, 2) + H.block(i, 5, 2, 2);
      const bool anchored = H.block(i, 3, 2, 4).isZero(0.0);
      EXPECT_LT(anchored ? 0.0 : sum.norm(), 1e-12);
      of_anchors += anchored ? 1 : 0;
    }
    EXPECT_EQ(loop.K[k - 1].cols(), 6);
    EXPECT_EQ(loop.K[k - 1].rows(), 7);
  }
  EXPECT_EQ(of_anchors, 40);
  EXPECT_GT(run.pose_nees, 0.0);
}

// With two anchors every state is seen at every step, H has full column rank, and K = P Hᵀ R⁻¹ gives the P of
// the step away: the plain recursion along the record leads from each to the next, and has its mean trace.
TEST(PlanarPathRun, TheRecordIsThatOfItsOwnCovariances) {
  const Scenario scenario = scenario_of_circle(2, 2);
  const PlanarPathRun run = follow_planar_path(scenario, 4, Linearisation::truth);
  ASSERT_TRUE(run.ok);
  const PlanarLoopRecord& loop = run.loop;
  const double bearing_std = scenario.noise.bearing_std_deg * std::numbers::pi / 180.0;
  Vector R(8);
  for (Index i = 0; i < 8; i += 2)
    R.segment<2>(i) << std::pow(scenario.noise.range_std, 2), std::pow(bearing_std, 2);
  Matrix P;
  double trace = 0.0;
  for (std::size_t k = 0; k < loop.F.size(); ++k) {
    const Matrix &H = loop.H[k + 1], &K = loop.K[k];
    ASSERT_EQ(H.rows(), 8);
    const Matrix now = K * R.asDiagonal() * H * (H.transpose() * H).inverse();
    trace += now.trace() / static_cast<double>(loop.F.size());
    if (k > 0) {
      const Matrix prior = loop.F[k] * P * loop.F[k].transpose() + loop.process[k];
      EXPECT_LT((prior - K * H * prior - now).norm(), 1e-9 * now.norm()) << k;
    }
    P = now;
    EXPECT_EQ(loop.inflation[k].norm(), 0.0);
    EXPECT_EQ(loop.process[k].bottomRows(4).norm(), 0.0);
  }
  EXPECT_NEAR(trace, run.traces.back(), 1e-9 * trace);
}

TEST(PlanarPathRun, OfLandmarksNotYetSeenHasNoRecord) {
  Scenario scenario = scenario_of_circle(3);
  scenario.world.sensor_range = 1e-6;
  const PlanarPathRun blind = follow_planar_path(scenario, 2, Linearisation::truth);
  ASSERT_TRUE(blind.ok);
  EXPECT_TRUE(blind.loop.H.empty());
  EXPECT_TRUE(blind.loop.F.empty());
  ASSERT_EQ(blind.traces.size(), 2U);
  EXPECT_GT(blind.traces[1], blind.traces[0]);  // nothing corrects the pose
  // In one loop no landmark is known when it begins.
  EXPECT_TRUE(follow_planar_path(scenario_of_circle(3), 1, Linearisation::truth).loop.F.empty());
}

TEST(PlanarPathRun, IsEndedWhereItIsStopped) {
  const std::atomic<bool> stop = true;
  const StopScope scope(&stop);
  EXPECT_THROW(follow_planar_path(scenario_of_circle(2), 4, Linearisation::truth), Stopped);
}

}  // namespace
}  // namespace credence::internal
