#include "montecarlo/worlds/world_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario localised(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"localisation\"\n", "t.toml", overrides);
}

std::string localisation_refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { localised(overrides); });
}

// [Brossard 2020]: a circle of 10 m across in 40 s, at 100 Hz for 40 s.
TEST(LocalisationWorld, ItsDefaultsAreThoseOfTheBenchmark) {
  const Scenario scenario = localised();
  EXPECT_DOUBLE_EQ(2.0 * std::numbers::pi * scenario.world.path_radius / scenario.world.speed, 40.0);
  EXPECT_DOUBLE_EQ(static_cast<double>(scenario.study.steps) * scenario.world.dt, 40.0);
  EXPECT_DOUBLE_EQ(scenario.noise.turn_rate_std, std::numbers::pi / 180.0);
  EXPECT_EQ(scenario.initial.position_std, 0.0);
  EXPECT_EQ(scenario.initial.heading_std_deg, 45.0);
}

TEST(LocalisationWorld, LandmarksBelongToTheirAiding) {
  EXPECT_EQ(localisation_refusal({"world.aiding=landmarks", "world.known_landmarks=5"}), "accepted");
  EXPECT_THAT(localisation_refusal({"world.aiding=satellites", "world.known_landmarks=5"}),
              HasSubstr("world.aiding = \"landmarks\""));
  for (const char* bad :
       {"world.known_landmarks=0", "world.known_landmarks=1001", "world.known_landmarks=2.5"}) {
    EXPECT_THAT(localisation_refusal({"world.aiding=landmarks", bad}), HasSubstr("integer from 1 to 1000"))
        << bad;
  }
  EXPECT_THAT(localisation_refusal({"world.landmarks=3"}), HasSubstr("accepted only with world.model"));
}

TEST(LocalisationWorld, IsAPoseInThePlane) {
  const Scenario scenario = localised({"study.steps=3"});
  EXPECT_FALSE(linear_problem(scenario).has_value());
  EXPECT_EQ(kLocalisationWorld.schema.blocks(scenario).vehicle, 3);
  const RunLayout layout = make_experiment(scenario)->layout();
  EXPECT_EQ(layout.states.size(), 3U);
  EXPECT_EQ(layout.angles, (std::vector<bool>{false, false, true}));
  EXPECT_THAT(world_text(scenario), HasSubstr("vehicle on a circle, its odometry noisy, aided by"));
}

}  // namespace
}  // namespace credence::internal
