#include "montecarlo/worlds/linear/linear_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using testing::ElementsAre;

TEST(LinearTrace, WhereAStartIsRandomTheEstimateIsWhatTheSceneSays) {
  LinearScene scene{.layout = {}, .start = Vector{{1.0, -2.0}}};
  const Vector error{{0.5, 0.25}};  // x − x̂
  TraceStep step;
  // The truth starts at the scene's place and the estimate is off …
  Vector x = linear_start(scene, error);
  set_error(x, error, step);
  EXPECT_EQ(step.truth, scene.start);
  EXPECT_EQ(step.estimate, (Vector{{0.5, -2.25}}));
  // … or the estimate does, and the truth is off.
  scene.random_start = true;
  x = linear_start(scene, error);
  set_error(x, error, step);
  EXPECT_EQ(step.estimate, scene.start);
  EXPECT_EQ(step.truth, (Vector{{1.5, -1.75}}));
  EXPECT_EQ(step.error, Vector(step.estimate - step.truth));
}

TEST(LinearTrace, AllStatesAndLandmarksAreKnownFromTheStart) {
  TraceStep step;
  step.landmarks = {7};
  step.states = {9, 9, 9, 9, 9, 9, 9, 9};
  name_states({.vehicle = 1, .landmark = 2, .landmarks = 2}, step);
  EXPECT_THAT(step.landmarks, ElementsAre(0, 1));
  EXPECT_THAT(step.states, ElementsAre(0, 1, 2, 3, 4));
}

TEST(LinearTrace, SaysWhereLandmarksAndAnchorsStand) {
  const LinearScene scene{.layout = {},
                          .start = Vector::Zero(1),
                          .landmark_positions = Matrix{{1.0, 2.0}},
                          .anchor_positions = Matrix{{3.0}}};
  const RunTrace trace = describe_scene(scene);
  EXPECT_EQ(trace.landmark_positions, scene.landmark_positions);
  EXPECT_EQ(trace.anchor_positions, scene.anchor_positions);
}

}  // namespace
}  // namespace credence::internal
