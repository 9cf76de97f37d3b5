#include "montecarlo/worlds/planar/planar_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

std::string key_refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", overrides); });
}

TEST(PlanarKeys, AreDifferentAndEachSaysWhatItMeans) {
  std::set<std::pair<std::string, std::string>> seen;
  for (const KeyRow& row : planar_keys()) {
    EXPECT_TRUE(seen.emplace(row.section, row.name).second) << row.section << '.' << row.name;
    EXPECT_FALSE(row.meaning.empty()) << row.name;
  }
  EXPECT_TRUE(seen.contains({"noise", "steering_std_deg"}));
  EXPECT_TRUE(seen.contains({"filter", "inflation"})) << "those of every SLAM world";
}

// Another world has a row of the plane on a condition of its own, or on none.
TEST(PlanarKeys, ARowOfAnotherWorldHasItsOwnCondition) {
  const KeyRow plain = planar_row("noise", "turn_rate_std");
  EXPECT_EQ(plain.accepted, nullptr);
  EXPECT_TRUE(plain.accepted_when.empty());
  EXPECT_EQ(plain.unit, "rad/s");
  const KeyRow never = planar_row(
      "noise", "turn_rate_std", [](const Scenario&) { return false; }, "never");
  ASSERT_NE(never.accepted, nullptr);
  EXPECT_FALSE(never.accepted(Scenario{}));
  EXPECT_EQ(never.accepted_when, "never");
  for (const KeyRow& row : planar_keys()) {
    const KeyRow found = planar_row(row.section, row.name);
    EXPECT_EQ(found.section, row.section) << row.name;
    EXPECT_EQ(found.name, row.name);
    EXPECT_EQ(found.meaning, row.meaning);
  }
}

// Each number at the ends of what it may be.
TEST(PlanarKeys, TakeWhatTheirIntervalsSay) {
  for (const char* good :
       {"world.field_of_view_deg=360", "world.field_of_view_deg=1e-3", "world.sensor_min_range=0",
        "noise.speed_std=0", "noise.range_std=0", "initial.heading_std_deg=0", "world.path_radius=1e-3"}) {
    EXPECT_EQ(key_refusal({good}), "accepted") << good;
  }
  for (const char* bad :
       {"world.field_of_view_deg=0", "world.field_of_view_deg=360.1", "world.sensor_min_range=-1",
        "world.sensor_range=0", "world.dt=0", "world.speed=0", "world.path_radius=0", "noise.speed_std=-1",
        "noise.range_std=nan", "initial.position_std=-1", "noise.bearing_std_deg=inf"}) {
    const std::string key = std::string(bad).substr(0, std::string(bad).find('='));
    EXPECT_THAT(key_refusal({bad}), testing::HasSubstr("--set " + key + "=")) << bad;
  }
}

TEST(PlanarKeys, TheNoiseOfTheTurnIsThatOfTheVehicle) {
  EXPECT_EQ(key_refusal({"noise.turn_rate_std=1"}), "accepted");
  EXPECT_THAT(key_refusal({"noise.steering_std_deg=1"}), testing::HasSubstr("\"bicycle\" or \"car\""));
  for (const char* vehicle : {"world.vehicle=bicycle", "world.vehicle=car"}) {
    EXPECT_EQ(key_refusal({vehicle, "noise.steering_std_deg=1"}), "accepted");
    EXPECT_THAT(key_refusal({vehicle, "noise.turn_rate_std=1"}),
                testing::HasSubstr("world.vehicle = \"unicycle\""));
  }
}

}  // namespace
}  // namespace credence::internal
