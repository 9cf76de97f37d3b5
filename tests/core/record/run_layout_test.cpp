#include "core/record/run_layout.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using testing::ElementsAre;

RunLayout named(std::vector<std::string> states) {
  RunLayout layout{.states = std::move(states)};
  for (const std::string& state : layout.states) layout.angles.push_back(state.ends_with("heading"));
  add_named_blocks(layout);
  return layout;
}

std::vector<std::string> names(const RunLayout& layout) {
  std::vector<std::string> all;
  for (const Block& block : layout.blocks) all.push_back(block.name);
  return all;
}

TEST(NamedBlocks, AreThoseBeforeTheDot) {
  const RunLayout layout = named({"arm.angle", "bias", "arm.rate"});
  EXPECT_THAT(names(layout), ElementsAre("arm", "bias"));
  EXPECT_THAT(layout.blocks[0].states, ElementsAre(0, 2));
  EXPECT_EQ(layout.blocks[0].part, Part::other);
  EXPECT_EQ(layout.landmark_dim, 0);
}

TEST(NamedBlocks, AVehicleInThePlaneHasAPlaceAHeadingAndAMap) {
  const RunLayout layout = named({"vehicle.x", "vehicle.y", "vehicle.heading", "landmark2.x", "landmark2.y"});
  EXPECT_THAT(names(layout), ElementsAre("vehicle", "landmark2", "position", "heading", "all landmarks"));
  EXPECT_EQ(layout.blocks[0].part, Part::pose);
  EXPECT_EQ(layout.blocks[1].part, Part::landmark);
  EXPECT_THAT(layout.blocks[4].states, ElementsAre(3, 4));
  EXPECT_EQ(layout.landmark_dim, 2);
  EXPECT_THAT(layout.units, ElementsAre("m", "m", "rad", "m", "m"));
}

TEST(NamedBlocks, UnitsThatAreToldStay) {
  RunLayout layout{.states = {"vehicle", "landmark1"}, .units = {"km", ""}};
  add_named_blocks(layout);
  EXPECT_THAT(layout.units, ElementsAre("km", ""));
  EXPECT_THAT(named({"vehicle", "landmark1", "bias"}).units, ElementsAre("m", "m", ""));
  EXPECT_THAT(named({"x", "bias"}).units, testing::IsEmpty()) << "not known";
}

// Whoever judges a pose finds x, y and heading in its block, however the columns stand in the file.
TEST(NamedBlocks, APoseIsKnownInAnyOrder) {
  const RunLayout layout =
      named({"vehicle.heading", "landmark1.y", "vehicle.y", "bias", "landmark1.x", "vehicle.x"});
  EXPECT_THAT(names(layout),
              ElementsAre("vehicle", "landmark1", "bias", "position", "heading", "all landmarks"));
  EXPECT_EQ(layout.blocks[0].part, Part::pose);
  EXPECT_THAT(layout.blocks[0].states, ElementsAre(5, 2, 0));
  EXPECT_THAT(layout.blocks[1].states, ElementsAre(4, 1));
  EXPECT_THAT(layout.blocks[3].states, ElementsAre(5, 2));
  EXPECT_THAT(layout.blocks[4].states, ElementsAre(0));
  EXPECT_THAT(layout.blocks[5].states, ElementsAre(1, 4));
  EXPECT_THAT(named({"vehicle.north", "vehicle.heading", "vehicle.east"}).blocks[0].states,
              ElementsAre(0, 2, 1));
  EXPECT_EQ(named({"vehicle.x", "vehicle.y", "vehicle.z"}).blocks[0].part, Part::other);
}

// As run judges them (slam_layout), whichever was seen first.
TEST(NamedBlocks, OfManyLandmarksTheFirstByNumberStandAlone) {
  constexpr int kLandmarks = 120;
  std::vector<std::string> states = {"vehicle"};
  for (int i = kLandmarks; i >= 1; --i) states.push_back(fmt::format("landmark{}", i));
  const RunLayout layout = named(states);
  ASSERT_EQ(std::ssize(layout.blocks), 1 + kSingleLandmarks + 1);
  for (Index i = 0; i < kSingleLandmarks; ++i) {
    EXPECT_EQ(layout.blocks[static_cast<std::size_t>(1 + i)].name,
              fmt::format("landmark{}", kSingleLandmarks - i));
  }
  EXPECT_EQ(layout.blocks.back().name, "all landmarks");
  EXPECT_EQ(std::ssize(layout.blocks.back().states), kLandmarks);
}

TEST(NamedBlocks, AsManyAsStandAloneAllDo) {
  std::vector<std::string> states = {"vehicle"};
  for (int i = 1; i <= kSingleLandmarks; ++i) states.push_back(fmt::format("landmark{}", i));
  EXPECT_EQ(std::ssize(named(states).blocks), 1 + kSingleLandmarks + 1);
}

TEST(UnitOfStates, IsThatOfTheLayoutWhereTheyShareOneAndRadOfAngles) {
  const RunLayout layout{.states = {"x", "y", "v", "yaw", "pitch", "k"},
                         .angles = {false, false, false, true, false, false},
                         .units = {"m", "m", "m/s", "", "rad", ""}};
  EXPECT_EQ(unit_of_states(layout, {0}), "m");
  EXPECT_EQ(unit_of_states(layout, {0, 1}), "m");
  EXPECT_EQ(unit_of_states(layout, {0, 2}), "") << "they differ";
  EXPECT_EQ(unit_of_states(layout, {3}), "rad") << "by the angles alone";
  EXPECT_EQ(unit_of_states(layout, {4, 3}), "rad");
  EXPECT_EQ(unit_of_states(layout, {5}), "") << "not known";
  EXPECT_EQ(unit_of_states(layout, {0, 5}), "");
  EXPECT_EQ(unit_of_states(layout, {}), "");
  EXPECT_EQ(unit_of_states(layout, {6}), "") << "no state";
  const RunLayout without{.states = {"x", "yaw"}, .angles = {false, true}};
  EXPECT_EQ(unit_of_states(without, {0}), "");
  EXPECT_EQ(unit_of_states(without, {1}), "rad");
}

TEST(NoPose, IsSaidOfAVehicleOfOtherStates) {
  using testing::HasSubstr;
  EXPECT_EQ(no_pose_sentence(named({"x", "y"})), "");
  EXPECT_EQ(no_pose_sentence(named({"vehicle.x"})), "");
  EXPECT_EQ(no_pose_sentence(named({"vehicle.x", "vehicle.y", "vehicle.heading"})), "");
  EXPECT_THAT(no_pose_sentence(named({"vehicle.x", "vehicle.y", "vehicle.heading", "vehicle.speed"})),
              HasSubstr("vehicle.… are 4 states, 1 of them angles"));
  EXPECT_THAT(no_pose_sentence(named({"vehicle.x", "vehicle.y", "vehicle.yaw"})),
              HasSubstr("3 states, 0 of them angles"));
}

}  // namespace
}  // namespace credence::internal
