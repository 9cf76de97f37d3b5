#include "datasets/replay/replay_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/manifold/angle.h"
#include "tests/datasets/replay/replay_world.h"

namespace credence::internal {
namespace {

using World = test::ReplayWorld;

// In a world as the filter assumes it NEES and NIS have the means 3, 2, 2. The bounds are 5 standard errors
// of the mean over runs (NEES at the last step) and of the sum over observations (NIS is white).
TEST(ReplayFilter, IsConsistentWhereItsAssumptionsHold) {
  const World world;
  constexpr int kRuns = 60, kSteps = 60;
  double nees = 0, landmark_nees = 0, nis = 0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const ReplayResult result = world.run(seed, kSteps);
    nees += result.references.back().nees / kRuns;
    landmark_nees += result.landmark_nees.mean() / kRuns;
    nis += result.nis.mean() / kRuns;
  }
  EXPECT_NEAR(nees, 3, 5 * std::sqrt(2 * 3.0 / kRuns));
  EXPECT_NEAR(landmark_nees, 2, 5 * std::sqrt(2 * 2.0 / kRuns));
  EXPECT_NEAR(nis, 2, 5 * std::sqrt(2 * 2.0 / (kRuns * (kSteps - 1) * 4)));
}

// The power of the same test: range noise of twice or half the assumed is found in one run.
TEST(ReplayFilter, NisTellsWrongNoise) {
  const World world;
  constexpr int kSteps = 60;
  const double five_errors = 5 * std::sqrt(2 * 2.0 / ((kSteps - 1) * 4));
  EXPECT_GT(world.run(1, kSteps, 2.0).nis.mean(), 2 + five_errors);
  EXPECT_LT(world.run(1, 4 * kSteps, 0.5).nis.mean(), 2 - five_errors / 2);
}

// A truth that moves as the control says is the same with gaps and without.
TEST(ReplayFilter, InAGapTheTruthMovesAsTheControlSays) {
  World world;
  const auto covariance = [&world](const char* estimator, int every) {
    std::vector<Pose> path = {world.start.pose};
    for (int k = 0; k < 30; ++k) path.push_back(world.vehicle.moved(path.back(), Control(0.5, 0.2), 0.1));
    world.settings.filter.estimator = estimator;
    world.settings.filter.jacobians =
        estimator == std::string("ekf") ? ReplayJacobians::truth : ReplayJacobians::estimate;
    world.start.truth = [&](double time_s) -> std::optional<Pose> {
      const auto k = static_cast<std::size_t>(std::lround(10.0 * (time_s - world.start.time_s)));
      if (k % static_cast<std::size_t>(every) != 0) return std::nullopt;
      return path.at(k);
    };
    return world.run(3, 30).map_covariance;
  };
  for (const char* estimator : {"ekf", "ideal"}) {
    const Matrix whole = covariance(estimator, 1), with_gaps = covariance(estimator, 7);
    EXPECT_LT((whole - with_gaps).norm(), 1e-9 * whole.norm()) << estimator;
  }
}

TEST(ReplayFilter, EveryObservationHasOneOutcome) {
  const World world;
  const ReplayResult result = world.run(7, 50);
  EXPECT_EQ(result.observations, 200);
  EXPECT_EQ(result.scans_with_observations, 50);
  EXPECT_EQ(result.associated, 200);
  EXPECT_EQ(result.initialised, 4);
  EXPECT_EQ(result.updated, 196);
  EXPECT_EQ(result.nis.count, 196);
  EXPECT_EQ(result.updates.size(), 49U);
  EXPECT_EQ(result.steps.size(), 50U);
  EXPECT_EQ(result.references.size(), 50U);
  EXPECT_EQ(result.map.size(), 4U);
  EXPECT_NEAR(result.duration_s, 5, 1e-9);
  EXPECT_NEAR(result.steps.back().time_s, 5, 1e-9);
  EXPECT_GT(result.steps.back().gain.range, 0);
  EXPECT_GT(result.steps.back().landmarks[0].gain.bearing, 0);
  EXPECT_EQ(result.nis.expected, 2);
}

TEST(ReplayFilter, AnchorsAreNoStates) {
  World world;
  world.settings.world = {.full = true, .anchors = 2};
  world.start.first_seen = {2, 0, 1, 3};
  const ReplayResult result = world.run(7, 50);
  EXPECT_EQ(result.anchors, (std::vector<int>{2, 0}));
  EXPECT_EQ(result.map.size(), 2U);
  EXPECT_EQ(result.updated, 198);
}

/// A filter that stands still at the origin and knows landmark 0 and, half a metre beside it, landmark 1.
ReplayFilter standing_filter(double gate, ReplayAssociation association) {
  World world;
  world.settings.filter.gate = gate;
  world.settings.filter.association = association;
  world.start.survey_m = {{4, 0}, {4, 0.5}, {-20, 0}};
  ReplayFilter filter(world.settings, world.start);
  for (int k = 0; k < 20; ++k)
    filter.observe(
        world.start.time_s + 1e-3 * k,
        std::vector<LoggedObservation>{{0, {4, 0}}, {1, {std::hypot(4, 0.5), std::atan2(0.5, 4)}}});
  return filter;
}

TEST(ReplayFilter, TheGateRejectsAndCounts) {
  ReplayFilter filter = standing_filter(0.99, ReplayAssociation::survey);
  filter.observe(100.1, std::vector<LoggedObservation>{{0, {5, 0}}});   // a metre too far
  filter.observe(100.2, std::vector<LoggedObservation>{{0, {4, 0}}});   // right
  filter.observe(100.3, std::vector<LoggedObservation>{{-1, {9, 1}}});  // nobody's
  const ReplayResult result = filter.finish();
  EXPECT_EQ(result.rejected, 1);
  EXPECT_EQ(result.unassociated, 1);
  EXPECT_EQ(result.associated, 42);
  EXPECT_EQ(result.updated, 39);
  EXPECT_EQ(result.ambiguous, 0);
  EXPECT_EQ(result.nis.count, 39) << "a rejected observation is not in the mean";
  EXPECT_GT(result.records[40].nis, 9.21);
  EXPECT_NEAR(result.records[40].innovation(0), 1, 0.01);
  EXPECT_NEAR(result.nis.expected, 1.907, 5e-4) << "theory, section 7";
}

TEST(ReplayFilter, CompatibilityFindsLandmarksByItself) {
  ReplayFilter filter = standing_filter(0.99, ReplayAssociation::compatibility);
  filter.observe(100.1, std::vector<LoggedObservation>{{2, {20, 3.1}}});  // far from all: new
  filter.observe(100.2, std::vector<LoggedObservation>{{1, {4, 0}}});     // says 1, looks like 0
  filter.observe(100.3, std::vector<LoggedObservation>{{0, {4.2, 0}}});   // neither fits nor is new
  const ReplayResult result = filter.finish();
  EXPECT_EQ(result.initialised, 3);
  EXPECT_EQ(result.map.size(), 3U);
  EXPECT_EQ(result.map[2].landmark, 2);
  EXPECT_EQ(result.mismatched, 1);
  EXPECT_EQ(result.rejected, 1);
  EXPECT_EQ(result.updated, 39);
}

// Two landmarks that the filter cannot tell apart.
TEST(ReplayFilter, AmbiguousObservationsAreCounted) {
  World world;
  world.settings.filter.gate = 0.99;
  world.start.survey_m = {{4, 0}, {4, 0.02}};
  ReplayFilter filter(world.settings, world.start);
  filter.observe(101, std::vector<LoggedObservation>{{0, {4, 0}}, {1, {4, 0.005}}});
  filter.observe(102, std::vector<LoggedObservation>{{0, {4, 0}}});
  const ReplayResult result = filter.finish();
  EXPECT_EQ(result.ambiguous, 1);
  EXPECT_EQ(result.updated, 1) << "known association uses it all the same";
}

TEST(ReplayFilter, ALandmarkSeenTwiceAtOneTimeIsUsedTwice) {
  World world;
  ReplayFilter filter(world.settings, world.start);
  filter.observe(101, std::vector<LoggedObservation>{{0, {4, 0.2}}, {0, {4, 0.21}}});
  const ReplayResult result = filter.finish();
  EXPECT_EQ(result.initialised, 1);
  EXPECT_EQ(result.updated, 1);
  EXPECT_EQ(result.scans_with_observations, 1);
}

TEST(ReplayFilter, PositionsAreComparedWithoutTouchingTheFilter) {
  World world;
  ReplayFilter with(world.settings, world.start), without(world.settings, world.start);
  for (ReplayFilter* filter : {&with, &without}) filter->set_control({1, 0});
  with.compare_position(100.5, {0.5, 0});
  for (ReplayFilter* filter : {&with, &without}) filter->advance_to(101);
  const ReplayResult compared = with.finish(), plain = without.finish();
  ASSERT_EQ(compared.references.size(), 1U);
  EXPECT_NEAR(compared.references[0].estimate(0), 0.5, 1e-12) << "extrapolated to the time of the fix";
  EXPECT_EQ(compared.references[0].dof, 2);
  EXPECT_NEAR(compared.references[0].nees, 0, 1e-20);
  EXPECT_EQ(compared.covariance.vehicle_final, plain.covariance.vehicle_final);
}

// A pose that is known exactly has no NEES; it is kept and said, not averaged.
TEST(ReplayFilter, ASingularCovarianceIsSaid) {
  World world;
  world.settings.initial.position_std = 0;
  world.settings.initial.heading_std_deg = 0;
  ReplayFilter filter(world.settings, world.start);
  filter.compare_pose(100, world.start.pose);
  const ReplayResult result = filter.finish();
  EXPECT_TRUE(result.references[0].singular);
  EXPECT_EQ(result.vehicle_nees.count, 0);
}

TEST(ReplayFilter, ExpectedNisOfAGate) {
  EXPECT_EQ(expected_nis(0), 2);
  EXPECT_NEAR(expected_nis(0.99), 1.907, 5e-4);
  EXPECT_NEAR(gate_threshold(0.99), 9.21034, 1e-5);
  // The mean of the exponential law cut at g, by the midpoint rule.
  const double g = gate_threshold(0.9);
  double mean = 0, mass = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = g * (i + 0.5) / 20000;
    mean += x * std::exp(-x / 2);
    mass += std::exp(-x / 2);
  }
  EXPECT_NEAR(expected_nis(0.9), mean / mass, 1e-7);
}

}  // namespace
}  // namespace credence::internal
