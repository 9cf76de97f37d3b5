#include "montecarlo/worlds/slam_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

using testing::ElementsAre;

const Block* block_named(const RunLayout& layout, std::string_view name) {
  for (const Block& block : layout.blocks) {
    if (block.name == name) return &block;
  }
  return nullptr;
}

TEST(SlamLayout, OfAPlaneNamesPoseLandmarksAndMap) {
  const RunLayout layout = slam_layout({.vehicle = 3, .landmark = 2, .landmarks = 2}, 4, false);
  EXPECT_THAT(layout.states, ElementsAre("vehicle.x", "vehicle.y", "vehicle.heading", "landmark1.x",
                                         "landmark1.y", "landmark2.x", "landmark2.y"));
  EXPECT_THAT(layout.angles, ElementsAre(false, false, true, false, false, false, false));
  EXPECT_THAT(layout.units, ElementsAre("m", "m", "rad", "m", "m", "m", "m"));
  EXPECT_THAT(block_named(layout, "pose")->states, ElementsAre(0, 1, 2));
  EXPECT_THAT(block_named(layout, "position")->states, ElementsAre(0, 1));
  EXPECT_THAT(block_named(layout, "heading")->states, ElementsAre(2));
  EXPECT_THAT(block_named(layout, "landmark 2")->states, ElementsAre(5, 6));
  EXPECT_THAT(block_named(layout, "all landmarks")->states, ElementsAre(3, 4, 5, 6));
  EXPECT_EQ(block_named(layout, "all landmarks")->part, Part::map);
  EXPECT_EQ(layout.landmark_dim, 2);
  EXPECT_TRUE(layout.nonlinear);
  ASSERT_EQ(layout.sensors.size(), 1U);
  EXPECT_EQ(layout.sensors[0].dim, 4);
  EXPECT_EQ(layout.sensors[0].piece, 2) << "of one landmark each";
}

TEST(SlamLayout, OfALineHasNoAngle) {
  const RunLayout layout = slam_layout({.vehicle = 1, .landmark = 1, .landmarks = 2}, 3, true);
  EXPECT_THAT(layout.states, ElementsAre("vehicle", "landmark1", "landmark2"));
  EXPECT_THAT(layout.angles, ElementsAre(false, false, false));
  EXPECT_THAT(layout.units, ElementsAre("m", "m", "m"));
  EXPECT_EQ(block_named(layout, "pose"), nullptr);
  EXPECT_EQ(block_named(layout, "vehicle")->part, Part::position);
  EXPECT_FALSE(layout.nonlinear);
}

TEST(SlamLayout, AMapOfNothingIsNoBlock) {
  EXPECT_EQ(
      block_named(slam_layout({.vehicle = 3, .landmark = 2, .landmarks = 0}, 2, false), "all landmarks"),
      nullptr);
}

TEST(SlamLayout, OfManyLandmarksTheFirstHaveABlockOfTheirOwn) {
  const RunLayout layout =
      slam_layout({.vehicle = 1, .landmark = 1, .landmarks = kSingleLandmarks + 3}, 1, false);
  EXPECT_NE(block_named(layout, "landmark 50"), nullptr);
  EXPECT_EQ(block_named(layout, "landmark 51"), nullptr);
  EXPECT_EQ(std::ssize(block_named(layout, "all landmarks")->states), kSingleLandmarks + 3);
}

TEST(SlamLayout, AnInnovationIsTakenApartUnlessItIsSmallAndAlwaysTheSame) {
  const auto piece = [](Index measurements, bool constant) {
    return slam_layout({.vehicle = 1, .landmark = 1, .landmarks = 6}, measurements, constant)
        .sensors.front()
        .piece;
  };
  EXPECT_EQ(piece(4, true), 4);
  EXPECT_EQ(piece(5, true), 1);
  EXPECT_EQ(piece(4, false), 1);
}

TEST(SlamLayout, StatesFollowTheOrderInWhichLandmarksAreKnown) {
  std::vector<Index> states{99};
  slam_states({.vehicle = 3, .landmark = 2, .landmarks = 4}, std::vector<int>{2, 0}, states);
  EXPECT_THAT(states, ElementsAre(0, 1, 2, 7, 8, 3, 4));
  slam_states({.vehicle = 1, .landmark = 1, .landmarks = 4}, std::vector<int>{3}, states);
  EXPECT_THAT(states, ElementsAre(0, 4));
  slam_states({.vehicle = 3, .landmark = 2, .landmarks = 4}, {}, states);
  EXPECT_THAT(states, ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace credence::internal
