#include "montecarlo/worlds/world_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "montecarlo/worlds/spatial_slam/spatial_world.h"

namespace credence::internal {
namespace {

Scenario streamed_space(const std::vector<std::string>& more) {
  std::vector<std::string> overrides = {"study.steps=20", "world.landmarks=30", "world.sensor_range=30",
                                        "initial.heading_std_deg=3", "initial.position_std=0.2"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return load_scenario_text("[world]\nmodel = \"spatial_slam\"\n", "t.toml", overrides);
}

/// As the notes of the stream have it: place p, attitude Exp of a rotation vector.
SE3 pose_from(const Vector& numbers) { return {SO3::Exp(numbers.tail<3>()), numbers.head<3>()}; }

// The rows alone, read as their notes say: exact inputs lead from truth to truth, measurements are landmarks
// in the frame of the vehicle, and their errors are the shares of the length that the scenario states, within
// 5 standard errors √(2/n) of a variance.
TEST(SpatialStream, RowsAreWhatTheNotesSay) {
  const Scenario scenario = streamed_space({"noise.odometry_share=0.02", "noise.landmark_share=0.05"});
  const WorldStream stream = world_stream(scenario);
  const SpatialWorld world = make_spatial_world(scenario);
  double of_input = 0.0, of_place = 0.0;
  int inputs = 0, places = 0;
  for (std::int64_t run = 0; run < 40; ++run) {
    SE3 before;
    stream.visit(run, [&](std::int64_t k, const StreamRow& row) {
      const SE3 now = pose_from(row.truth);
      EXPECT_LT((now.translation() - world.path[static_cast<std::size_t>(k)].translation()).norm(), 1e-12);
      if (k > 0) {
        const Eigen::Vector3d v =
            before.rotation().matrix().transpose() * (now.translation() - before.translation());
        const Eigen::Vector3d turn = (before.rotation().inverse() * now.rotation()).Log();
        of_input += (row.input.head<3>() - v).squaredNorm() / v.squaredNorm();
        EXPECT_LT((row.input.tail<3>() - turn).norm(), 0.15 * turn.norm());
        inputs += 3;
        for (Index i = 0; i < row.measurement.size() / 3; ++i) {
          const Eigen::Vector3d z = row.measurement.segment<3>(3 * i);
          if (std::isnan(z[0])) continue;
          const Eigen::Vector3d exact = now.rotation().matrix().transpose() *
                                        (world.landmarks[static_cast<std::size_t>(i)] - now.translation());
          of_place += (z - exact).squaredNorm() / exact.squaredNorm();
          places += 3;
        }
      }
      before = now;
    });
  }
  ASSERT_GT(places, 1000);
  EXPECT_NEAR(of_input / (inputs * 0.02 * 0.02), 1.0, 5.0 * std::sqrt(2.0 / inputs));
  EXPECT_NEAR(of_place / (places * 0.05 * 0.05), 1.0, 5.0 * std::sqrt(2.0 / places));
}

// The prior is where the experiment's estimate starts.
TEST(SpatialStream, ThePriorIsTheEstimateOfTheExperiment) {
  const Scenario scenario = streamed_space({});
  const WorldStream stream = world_stream(scenario);
  const auto experiment = make_experiment(scenario);
  for (const std::int64_t run : {0, 5}) {
    const RunTrace trace = experiment->trace(run);
    std::int64_t steps = 0;
    stream.visit(run, [&](std::int64_t k, const StreamRow& row) {
      EXPECT_LT((row.truth - trace.steps[static_cast<std::size_t>(k)].truth).norm(), 1e-14) << k;
      ++steps;
      if (k > 0) {
        EXPECT_EQ(row.prior.size(), 0);
        return;
      }
      EXPECT_EQ(row.input.size(), 0);
      const Eigen::Vector3d off = pose_from(row.prior).translation() - pose_from(row.truth).translation();
      EXPECT_LT((off - trace.steps[0].error.head<3>()).norm(), 1e-13);
      EXPECT_GT(off.norm(), 0.0);
    });
    EXPECT_EQ(steps, 21);
  }
  EXPECT_EQ(stream.states.size(), 6U);
  EXPECT_EQ(stream.inputs.size(), 6U);
  EXPECT_EQ(stream.measurements.size(), 90U);
  EXPECT_EQ(stream.measurements[5], "landmark2.z");
  EXPECT_THAT(stream.notes, testing::HasSubstr("landmark30 = "));
}

}  // namespace
}  // namespace credence::internal
