#include "montecarlo/worlds/monobot/monobot_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "montecarlo/worlds/world_list.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

Scenario on_a_line(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"monobot\"\n", "t.toml", overrides);
}

// Theory, section 2: x = (vehicle, landmarks), F = I, the vehicle alone moves; z = −x of an anchor, whose
// known place is taken off, then l − x of every landmark.
TEST(MonobotProblem, IsTheModelOfTheTheory) {
  const LinearProblem problem = monobot_problem(on_a_line(
      {"world.landmarks=2", "world.observability=full", "world.anchors=1", "noise.process_variance=0.2",
       "noise.measurement_variance=0.3", "noise.initial_variance=4", "filter.process_scale=5",
       "filter.measurement_scale=7", "noise.detection_probability=0.9", "noise.measurement_delay=2"}));
  EXPECT_EQ(problem.truth.F, Matrix(Matrix::Identity(3, 3)));
  EXPECT_EQ(Matrix(problem.truth.G * problem.truth.Q * problem.truth.G.transpose()),
            Matrix(Eigen::Vector3d(0.2, 0.0, 0.0).asDiagonal()));
  EXPECT_EQ(problem.truth.H, (Matrix(3, 3) << -1, 0, 0, -1, 1, 0, -1, 0, 1).finished());
  EXPECT_EQ(problem.truth.R, Matrix(0.3 * Matrix::Identity(3, 3)));
  EXPECT_EQ(problem.truth.P0, Matrix(4.0 * Matrix::Identity(3, 3)));
  EXPECT_EQ(problem.assumed.Q, Matrix(5.0 * problem.truth.Q));
  EXPECT_EQ(problem.assumed.R, Matrix(7.0 * problem.truth.R));
  EXPECT_EQ(problem.assumed.P0, problem.truth.P0);
  EXPECT_EQ(problem.detection_probability, 0.9);
  EXPECT_EQ(problem.measurement_delay, 2);
  EXPECT_EQ(problem.scene.layout.sensors.front().variances, (std::vector<double>{7.0 * 0.3}));
}

TEST(MonobotScene, LandmarksStandAroundOneMetreHalfAMetreApart) {
  for (const Index landmarks : {0, 1, 2, 5}) {
    const LinearModel model = monobot_model(landmarks, 1, 0.1, 0.1, 1.0);
    const LinearScene scene = monobot_scene(model, true);
    ASSERT_EQ(scene.start.size(), landmarks + 1);
    EXPECT_EQ(scene.start[0], -1.0);
    EXPECT_FALSE(scene.random_start);
    ASSERT_EQ(scene.landmark_positions.cols(), landmarks);
    EXPECT_EQ(Vector(scene.landmark_positions.transpose()), Vector(scene.start.tail(landmarks)));
    EXPECT_EQ(scene.anchor_positions.cols(), 1);
    for (Index i = 1; i < landmarks; ++i) {
      EXPECT_DOUBLE_EQ(scene.landmark_positions(0, i) - scene.landmark_positions(0, i - 1), 0.5);
    }
    if (landmarks > 0) {
      EXPECT_NEAR(scene.landmark_positions.mean(), 1.0, 1e-15);
    }
  }
}

TEST(MonobotWorld, IsLinearAndRefusesWhatItHasNot) {
  const Scenario scenario = on_a_line({"world.landmarks=3"});
  EXPECT_TRUE(linear_problem(scenario).has_value());
  EXPECT_EQ(kMonobotWorld.experiment, nullptr);
  EXPECT_THAT(world_text(scenario), testing::HasSubstr("monobot, 3 landmarks"));
  const BlockLayout blocks = kMonobotWorld.schema.blocks(scenario);
  EXPECT_EQ(blocks.vehicle, 1);
  EXPECT_EQ(blocks.landmark, 1);
  EXPECT_EQ(blocks.landmarks, 3);
  const auto said = [](const std::vector<std::string>& overrides) -> std::string {
    return scenario_refusal([&] { on_a_line(overrides); });
  };
  EXPECT_THAT(said({"world.landmarks=0"}), testing::HasSubstr("world.landmarks=0"));
  EXPECT_EQ(said({"world.landmarks=0", "world.observability=full"}), "accepted")
      << "its anchor is there to see";
  EXPECT_THAT(said({"filter.inflation=rank", "filter.inflation_rank=9"}),
              testing::HasSubstr("filter.inflation_rank=9"));
  EXPECT_THAT(said({"noise.process_variance=-1"}), testing::HasSubstr("must be a finite number >= 0"));
}

}  // namespace
}  // namespace credence::internal
