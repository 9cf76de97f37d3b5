#include "datasets/replay/replay_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/datasets/replay/replay_world.h"

namespace credence::internal {
namespace {

testing::RecordedSink::Run log_of(const ReplayResult& replay) {
  testing::RecordedSink sink;
  read_replay(replay, sink);
  EXPECT_EQ(sink.runs.size(), 1U);
  return sink.runs.front();
}

ReplayObservation observation(double time_s, bool first = true) {
  ReplayObservation o;
  o.time_s = time_s;
  o.first_of_batch = first;
  o.innovation = RangeBearing(0.3, 0.04);
  o.S << 0.09, 0.0, 0.0, 0.04;
  o.whitened = RangeBearing(2.0, -1.0);
  o.root << 0.5, 0.0, 0.1, 0.2;
  return o;
}

ReplayReference reference(double time_s, Index dof) {
  ReplayReference r;
  r.time_s = time_s;
  r.dof = dof;
  r.estimate = Pose(1.0, 2.0, 3.0);
  r.truth = Pose(0.5, 2.5, dof == 3 ? -3.0 : 0.0);
  r.covariance = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
  return r;
}

TEST(ReplayLog, ARowEndsWithTheReferenceBehindItsInnovation) {
  ReplayResult replay;
  replay.references = {reference(0.5, 2), reference(1.0, 2), reference(3.0, 2)};
  replay.records = {observation(1.0), observation(1.0, false), observation(2.0), observation(4.0)};
  replay.records[1].outcome = ObservationOutcome::rejected;
  const auto log = log_of(replay);
  EXPECT_EQ(log.time_s, (std::vector<double>{0.5, 1.0, 3.0, 4.0}));
  ASSERT_EQ(log.steps.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(log.steps[k].step, static_cast<std::int64_t>(k) + 1);
    EXPECT_EQ(log.steps[k].states.size(), k < 3 ? 2U : 0U);
    ASSERT_EQ(log.steps[k].innovations.size(), 1U);
    EXPECT_EQ(log.steps[k].innovations[0].nu.size(), k == 0 ? 0 : 2);
  }
}

TEST(ReplayLog, APositionIsComparedWithoutAHeading) {
  ReplayResult replay;
  replay.settings.truth.position_std = 0.2;
  replay.references = {reference(1.0, 2)};
  const auto log = log_of(replay);
  EXPECT_EQ(log.layout.states, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(log.layout.units, (std::vector<std::string>{"m", "m"}));
  ASSERT_EQ(log.layout.blocks.size(), 1U);
  EXPECT_EQ(log.layout.blocks[0].part, Part::position);
  const Step& row = log.steps.front();
  EXPECT_EQ(row.error, Vector(Eigen::Vector2d(0.5, -0.5)));
  EXPECT_NEAR(row.P(0, 0), 0.1 + 0.04, 1e-15);
  EXPECT_NEAR(row.P(1, 1), 0.2 + 0.04, 1e-15);
}

TEST(ReplayLog, ThePoseIsComparedWithItsHeadingWrapped) {
  ReplayResult replay;
  replay.settings.truth.position_std = 0.0;
  replay.settings.truth.heading_std_deg = 90.0;
  replay.references = {reference(1.0, 3)};
  const auto log = log_of(replay);
  EXPECT_EQ(log.layout.angles, (std::vector<bool>{false, false, true}));
  EXPECT_EQ(log.layout.units, (std::vector<std::string>{"m", "m", "rad"}));
  const Step& row = log.steps.front();
  EXPECT_NEAR(row.error[2], 6.0 - 2.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(row.P(2, 2), 0.3 + 0.25 * std::numbers::pi * std::numbers::pi, 1e-12);
  EXPECT_TRUE(log_of(ReplayResult{}).layout.states.size() == 2 && !log_of(ReplayResult{}).layout.has_truth);
}

// Of S = L Lᵀ of a batch L_ii u_i is what the i-th observation adds to those before it.
TEST(ReplayLog, WithoutAGateAnObservationIsGivenThoseBeforeIt) {
  ReplayResult replay;
  replay.records = {observation(1.0), observation(1.0, false)};
  EXPECT_EQ(gate_of(replay), std::numeric_limits<double>::infinity());
  const auto log = log_of(replay);
  ASSERT_EQ(log.steps.size(), 2U);
  for (const Step& row : log.steps) {
    EXPECT_LT((row.innovations[0].nu - Vector(Eigen::Vector2d(1.0, 0.0))).norm(), 1e-15);
    EXPECT_NEAR(row.innovations[0].S(0, 0), 0.25, 1e-15);
    EXPECT_NEAR(row.innovations[0].S(0, 1), 0.05, 1e-15);
    EXPECT_NEAR(row.innovations[0].S(1, 1), 0.05, 1e-15);
  }
}

TEST(ReplayLog, WithAGateTheFirstOfEachBatchStandsAlone) {
  ReplayResult replay;
  replay.settings.filter.gate = 0.99;
  replay.records = {observation(1.0), observation(1.0, false), observation(2.0)};
  EXPECT_NEAR(gate_of(replay), -2.0 * std::log(0.01), 1e-12);
  const auto log = log_of(replay);
  ASSERT_EQ(log.steps.size(), 2U);
  EXPECT_EQ(log.steps[0].innovations[0].nu, Vector(replay.records[0].innovation));
  EXPECT_EQ(log.steps[0].innovations[0].S, Matrix(replay.records[0].S));
}

TEST(ReplayLog, SaysWhatTheFilterAssumes) {
  ReplayResult replay;
  replay.settings.noise.range_std = 0.5;
  replay.settings.noise.bearing_std_deg = 90.0;
  const RunLayout layout = log_of(replay).layout;
  ASSERT_EQ(layout.sensors.size(), 1U);
  EXPECT_NEAR(layout.sensors[0].variances[0], 0.25, 1e-15);
  EXPECT_NEAR(layout.sensors[0].variances[1], 0.25 * std::numbers::pi * std::numbers::pi, 1e-12);
  EXPECT_EQ(layout.sensors[0].angles, (std::vector<bool>{false, true}));
  EXPECT_TRUE(layout.nonlinear);
  EXPECT_FALSE(layout.inflated);
  replay.settings.filter.inflation = Inflation::map;
  replay.settings.filter.jacobians = ReplayJacobians::truth;
  EXPECT_TRUE(log_of(replay).layout.inflated);
  EXPECT_FALSE(log_of(replay).layout.nonlinear);
}

// The filter's own numbers: NIS of a batch is the sum of its rows', NEES that of the reference.
TEST(ReplayLog, HasTheNisAndTheNeesOfTheReplay) {
  const ReplayResult replay = test::ReplayWorld().run(3, 40);
  const auto log = log_of(replay);
  double nis = 0.0, nees = 0.0, of_updates = 0.0;
  for (const Step& row : log.steps) {
    const Innovation& innovation = row.innovations[0];
    if (innovation.nu.size() > 0) nis += innovation.nu.dot(innovation.S.ldlt().solve(innovation.nu));
    if (row.error.size() > 0) nees += row.error.dot(row.P.ldlt().solve(row.error));
  }
  for (const ReplayUpdate& update : replay.updates) of_updates += update.nis;
  EXPECT_NEAR(nis, of_updates, 1e-9 * of_updates);
  EXPECT_NEAR(nees, replay.vehicle_nees.sum, 1e-6 * replay.vehicle_nees.sum);
}

}  // namespace
}  // namespace credence::internal
