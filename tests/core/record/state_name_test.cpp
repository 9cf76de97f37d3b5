#include "core/record/state_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace credence::internal {
namespace {

using testing::ElementsAre;

std::string parts_of(std::string_view text) {
  const StateName state = state_name(text);
  return state.name + (state.angle ? "|angle|" : "|-|") + state.unit;
}

TEST(StateName, HasItsMarksBehindIt) {
  EXPECT_EQ(parts_of("velocity.x"), "velocity.x|-|");
  EXPECT_EQ(parts_of("velocity.x [m/s]"), "velocity.x|-|m/s");
  EXPECT_EQ(parts_of("velocity.x[ m/s ]"), "velocity.x|-|m/s");
  EXPECT_EQ(parts_of("attitude.yaw:angle"), "attitude.yaw|angle|");
  EXPECT_EQ(parts_of("attitude.yaw:angle [rad]"), "attitude.yaw|angle|rad");
  EXPECT_EQ(parts_of("bias [V] of it"), "bias [V] of it|-|") << "not at the end";
}

TEST(StateName, BracketsAroundNothingAreAPartOfIt) {
  EXPECT_EQ(parts_of("x[]"), "x[]|-|");
  EXPECT_EQ(parts_of("x[ ]"), "x[ ]|-|");
  EXPECT_EQ(parts_of("[m]"), "[m]|-|");
  EXPECT_EQ(parts_of("]"), "]|-|");
  EXPECT_EQ(parts_of(""), "|-|");
}

TEST(MarkedStates, TellUnitsThatNamesDoNot) {
  RunLayout layout{.states = {"vehicle.x", "vehicle.y", "vehicle.heading"}, .angles = {false, false, true}};
  add_named_blocks(layout);
  EXPECT_THAT(marked_states(layout), ElementsAre("vehicle.x", "vehicle.y", "vehicle.heading:angle"));
  layout.states.emplace_back("bias");
  layout.angles.push_back(false);
  layout.units.emplace_back("rad/s");
  EXPECT_THAT(marked_states(layout),
              ElementsAre("vehicle.x [m]", "vehicle.y [m]", "vehicle.heading:angle [rad]", "bias [rad/s]"));
  EXPECT_THAT(marked_states({.states = {"x"}, .angles = {false}}), ElementsAre("x"));
}

TEST(MarkedStates, AreReadBackAsTheSame) {
  const RunLayout layout{.states = {"position.x", "attitude.yaw", "temperature"},
                         .angles = {false, true, false},
                         .units = {"m", "rad", ""}};
  RunLayout read{.units = {}};
  for (const std::string& text : marked_states(layout)) {
    StateName state = state_name(text);
    read.states.push_back(state.name);
    read.angles.push_back(state.angle);
    read.units.push_back(state.unit);
  }
  EXPECT_EQ(read, layout);
}

TEST(RequireRadians, OfAnglesAlone) {
  require_radians({.states = {"x", "yaw"}, .angles = {false, true}, .units = {"deg", ""}});
  require_radians({.states = {"yaw"}, .angles = {true}, .units = {"rad"}});
  require_radians({.states = {"yaw"}, .angles = {true}});
  try {
    require_radians({.states = {"x", "yaw"}, .angles = {false, true}, .units = {"m", "deg"}});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "state 'yaw' is an angle, in 'deg'; an angle is in rad");
  }
}

}  // namespace
}  // namespace credence::internal
