#include "analysis/stability/planar_stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "analysis/stability/planar_path.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

/// A unicycle on a circle of 63 steps of 1 m, all landmarks in view unless the range is limited.
Scenario planar(Index landmarks, Index anchors, FilterInflation inflation, double sensor_range = 100.0) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = landmarks;
  s.world.anchors = anchors;
  s.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  s.world.dt = 1.0;
  s.world.path_radius = 63.0 / (2.0 * std::numbers::pi);
  s.world.sensor_range = sensor_range;
  s.noise.turn_rate_std = 0.02;
  s.filter.inflation = inflation;
  return s;
}

// With measurements so exact that S is singular to rounding.
TEST(PlanarStability, AFilterThatFailsIsToldBesideTheOthers) {
  Scenario s = planar(3, 0, FilterInflation::map, 12.0);
  s.noise.range_std = 1e-9;
  const PlanarStability a = analyse_planar_stability(s, 4);
  EXPECT_EQ(a.state_dim, 9);
  const PlanarFollowed& failed = a.own(InflationSolution::pairwise);
  EXPECT_EQ(failed.growth.verdict, LongRun::failed);
  EXPECT_GT(failed.failed_at, 0);
  EXPECT_TRUE(std::isnan(failed.growth.exponent) && std::isnan(failed.initial_effect));
  EXPECT_TRUE(std::isnan(a.own(InflationSolution::pairwise, Linearisation::estimate).pose_nees));
  const PlanarFollowed& drop = a.own(InflationSolution::drop);
  EXPECT_EQ(drop.growth.verdict, LongRun::bounded);
  EXPECT_EQ(drop.failed_at, 0);
  EXPECT_GT(drop.initial_effect, 1.0);
}

// theory, section 5, the first three rows of the planar table.
TEST(PlanarStability, RanksAtTheTruthAndAtTheEstimate) {
  struct {
    Index anchors, lost_at_truth, lost_at_estimate;
  } const cases[] = {{0, 3, 2}, {1, 1, 0}, {2, 0, 0}};
  for (const auto& c : cases) {
    SCOPED_TRACE(::testing::Message() << c.anchors << " anchors");
    const PlanarStability a = analyse_planar_stability(planar(4, c.anchors, FilterInflation::none), 4);
    EXPECT_EQ(a.state_dim, 11);
    EXPECT_EQ(a.steps_per_loop, 63);
    EXPECT_EQ(a.state_dim - a.truth.observability.decision.rank, c.lost_at_truth);
    EXPECT_EQ(a.state_dim - a.estimate.observability.decision.rank, c.lost_at_estimate);
    ASSERT_EQ(a.truth.unobservable.size(), static_cast<std::size_t>(c.lost_at_truth));
    if (c.anchors == 0) {
      EXPECT_EQ(a.truth.unobservable[0], "common translation x");
      EXPECT_EQ(a.truth.unobservable[1], "common translation y");
      EXPECT_EQ(a.truth.unobservable[2], "rotation about the origin");
    }
    if (c.anchors == 1) {
      EXPECT_EQ(a.truth.unobservable[0].substr(0, 25), "rotation about the anchor");
    }
    EXPECT_EQ(a.process_rank, 3);  // the vehicle alone
  }
}

TEST(PlanarStability, RefusesALoopThatIsNoneOrHasNoEnd) {
  struct {
    double path_radius, dt;
  } const cases[] = {{10.0, 7e10}, {1e20, 1.0}, {1e8, 1.0}, {10.0, 1e-300}};
  for (const auto& c : cases) {
    Scenario s = planar(3, 0, FilterInflation::none);
    s.world.path_radius = c.path_radius;
    s.world.dt = c.dt;
    try {
      analyse_planar_stability(s, 4);
      ADD_FAILURE() << c.path_radius << " " << c.dt;
    } catch (const std::invalid_argument& error) {
      for (const char* key : {"world.path_radius", "world.speed", "world.dt"})
        EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
    }
  }
}

TEST(PlanarStability, WithoutInflationTheCovarianceStaysBounded) {
  const PlanarStability a = analyse_planar_stability(planar(3, 0, FilterInflation::none), 12);
  ASSERT_EQ(a.followed.size(), 2U);
  EXPECT_THROW(a.own(InflationSolution::drop), std::invalid_argument) << "another's numbers are not its own";
  const PlanarFollowed& truth = a.followed.front();
  EXPECT_EQ(truth.growth.verdict, LongRun::bounded) << truth.growth.exponent;
  ASSERT_TRUE(truth.exact.has_value());
  EXPECT_TRUE(truth.exact->bounded());
  EXPECT_EQ(truth.exact->reason, BoundednessReason::paired);
  EXPECT_EQ(truth.inflation_rank, 0);
  EXPECT_GT(truth.initial_effect, 2.0);  // the common motion of the map keeps what it began with
  EXPECT_TRUE(std::isnan(truth.pose_nees));
  EXPECT_FALSE(std::isnan(a.followed.back().pose_nees));
}

// theory, section 5: of the map alone, the pairwise sum is unbounded and the exact least trace is not.
TEST(PlanarStability, TheBoundThatIsUsedDecides) {
  const PlanarStability a = analyse_planar_stability(planar(4, 0, FilterInflation::map, 12.0), 20);
  const PlanarFollowed& pairwise = a.own(InflationSolution::pairwise);
  EXPECT_EQ(pairwise.growth.verdict, LongRun::growing);
  EXPECT_GT(pairwise.growth.exponent, 0.8);
  EXPECT_FALSE(pairwise.exact->bounded());
  const PlanarFollowed& exact = a.own(InflationSolution::min_trace);
  EXPECT_EQ(exact.growth.verdict, LongRun::bounded) << exact.growth.exponent;
  EXPECT_EQ(exact.not_converged, 0);
  EXPECT_LT(exact.traces.back(), 0.1 * pairwise.traces.back());
  const PlanarFollowed& sequential = a.own(InflationSolution::sequential);
  EXPECT_EQ(sequential.growth.verdict, LongRun::bounded) << sequential.growth.exponent;
  EXPECT_LT(sequential.growth.exponent, 0.002);  // it may fall
  EXPECT_FALSE(sequential.exact.has_value());
  EXPECT_LT(sequential.spectral_radius, 1.001);
  const PlanarFollowed& drop = a.own(InflationSolution::drop);
  EXPECT_EQ(drop.growth.verdict, LongRun::bounded) << drop.growth.exponent;
  EXPECT_FALSE(drop.exact.has_value());
}

TEST(PlanarStability, TwoAnchorsForgetTheStart) {
  const PlanarStability a = analyse_planar_stability(planar(3, 2, FilterInflation::full), 12);
  for (const InflationSolution solution : {InflationSolution::pairwise, InflationSolution::min_trace}) {
    const PlanarFollowed& f = a.own(solution);
    EXPECT_EQ(f.growth.verdict, LongRun::bounded);
    EXPECT_TRUE(f.exact->bounded());
    EXPECT_EQ(f.exact->reason, BoundednessReason::nothing_unobserved);
    EXPECT_NEAR(f.initial_effect, 1.0, 0.01);
    EXPECT_LT(f.spectral_radius, 1.0);
  }
}

TEST(PlanarPath, JacobiansAtTheTruthBelongToTheNominalPath) {
  const Scenario scenario = planar(3, 0, FilterInflation::map);
  const PlanarPathRun run = follow_planar_path(scenario, 4, Linearisation::truth);
  ASSERT_TRUE(run.ok);
  ASSERT_EQ(run.traces.size(), 4U);
  ASSERT_EQ(run.loop.F.size(), 63U);
  ASSERT_EQ(run.loop.H.size(), 64U);
  EXPECT_EQ(run.loop.H.front().rows(), 0);
  EXPECT_EQ(run.loop.H.back().rows(), 6);
  // The speed is 1 m/s and dt 1 s: the vehicle moves 1 m across its heading for every radian of it.
  for (const Matrix& F : run.loop.F) EXPECT_NEAR((F.block<2, 1>(0, 2).norm()), 1.0, 1e-6);
  // Moving everything together changes no measurement.
  Vector shift = Vector::Zero(9);
  for (const Index i : {0, 3, 5, 7}) shift[i] = 1.0;
  for (const Matrix& H : run.loop.H) EXPECT_LT((H * shift).norm(), 1e-12);
}

TEST(PlanarStability, RefusesWhatItCannotFollow) {
  EXPECT_THROW(analyse_planar_stability(planar(2, 0, FilterInflation::none), 3), std::invalid_argument);
  EXPECT_THROW(analyse_planar_stability(planar(2, 0, FilterInflation::rank), 8), std::invalid_argument);
  EXPECT_THROW(analyse_planar_stability(default_scenario("monobot"), 8), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
