#include "montecarlo/worlds/world_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

Scenario inertial_scenario(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"inertial\"\n", "t.toml", overrides);
}

std::string inertial_refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { inertial_scenario(overrides); });
}

// [Xsens 2018]: 0.01 °/s/√Hz and 60 µg/√Hz.
TEST(InertialWorld, ItsUnitIsThatOfTheManual) {
  const Scenario scenario = inertial_scenario();
  EXPECT_DOUBLE_EQ(real_value(scenario, "noise.gyro_density"), 0.01 * std::numbers::pi / 180.0);
  EXPECT_DOUBLE_EQ(real_value(scenario, "noise.accelerometer_density"), 60.0 * 9.80665e-6);
  EXPECT_EQ(scenario.world.path_radius, 50.0);
  EXPECT_EQ(scenario.world.speed, 10.0);
  EXPECT_EQ(scenario.world.dt, 0.01);
  EXPECT_EQ(scenario.study.steps, 3000);
  EXPECT_EQ(scenario.initial.position_std, 1.0);
}

// What a switch turns off can be written and makes no other configuration.
TEST(InertialWorld, ConingAndScullingAreSwitches) {
  const Scenario plain = inertial_scenario();
  for (const char* off : {"world.coning_frequency=5", "world.sculling_acceleration=3"}) {
    EXPECT_EQ(configuration_id(inertial_scenario({off})), configuration_id(plain)) << off;
    EXPECT_NE(configuration_id(inertial_scenario({"world.coning_angle_deg=1", off})),
              configuration_id(inertial_scenario({"world.coning_angle_deg=1"})))
        << off;
  }
  EXPECT_THAT(world_text(plain), Not(HasSubstr("coning")));
  EXPECT_THAT(world_text(inertial_scenario({"world.coning_angle_deg=1"})),
              AllOf(HasSubstr(", coning,"), Not(HasSubstr("sculling"))));
  EXPECT_THAT(world_text(inertial_scenario({"world.coning_angle_deg=1", "world.sculling_acceleration=3"})),
              HasSubstr(", coning and sculling,"));
  EXPECT_THAT(world_text(inertial_scenario({"world.sculling_acceleration=3"})), Not(HasSubstr("sculling")));
}

TEST(InertialWorld, KeysBelongToTheirAidingAndTakeWhatTheySay) {
  EXPECT_EQ(inertial_refusal({"noise.velocity_std=0.2"}), "accepted");
  EXPECT_THAT(inertial_refusal({"world.aiding=landmarks", "noise.velocity_std=0.2"}),
              HasSubstr("world.aiding = \"satellites\""));
  EXPECT_EQ(inertial_refusal({"noise.gyro_density=0"}), "accepted");
  for (const char* bad : {"noise.gyro_density=-1", "noise.velocity_std=0", "world.coning_frequency=0",
                          "initial.attitude_std_deg=nan", "world.attitude=fxed"}) {
    const std::string key = std::string(bad).substr(0, std::string(bad).find('='));
    EXPECT_THAT(inertial_refusal({bad}), HasSubstr("--set " + key + "=")) << bad;
  }
}

TEST(InertialWorld, IsNotLinearAndHasFifteenStates) {
  const Scenario scenario = inertial_scenario({"study.steps=2"});
  EXPECT_FALSE(linear_problem(scenario).has_value());
  EXPECT_EQ(kInertialWorld.schema.blocks(scenario).vehicle, 15);
  EXPECT_EQ(make_experiment(scenario)->layout().states.size(), 15U);
}

}  // namespace
}  // namespace credence::internal
