#include "datasets/replay/replay_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string error_of(const std::string& key, const std::string& value) {
  ReplaySettings settings;
  try {
    set_replay_setting(settings, key, value);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReplaySettings, AreSetByTheirNames) {
  ReplaySettings settings;
  set_replay_setting(settings, "world.observability", "full");
  set_replay_setting(settings, "world.anchors", "2");
  set_replay_setting(settings, "filter.inflation", "map");
  set_replay_setting(settings, "filter.solution", "min-trace");
  set_replay_setting(settings, "filter.association", "compatibility");
  set_replay_setting(settings, "filter.gate", "0.99");
  set_replay_setting(settings, "initial.position_std", "0.316");
  set_replay_setting(settings, "initial.heading_deg", "-112");
  set_replay_setting(settings, "noise.steering_std_deg", "3.5");
  set_replay_setting(settings, "sensor.bearing_offset_deg", "0.8");
  EXPECT_TRUE(settings.world.full);
  EXPECT_EQ(settings.world.anchors, 2);
  EXPECT_EQ(settings.filter.inflation, Inflation::map);
  EXPECT_EQ(settings.filter.solution, InflationSolution::min_trace);
  EXPECT_EQ(settings.filter.association, ReplayAssociation::compatibility);
  EXPECT_EQ(settings.filter.gate, 0.99);
  EXPECT_EQ(settings.initial.position_std, 0.316);
  EXPECT_EQ(settings.initial.heading_deg, -112);
  EXPECT_EQ(settings.noise.steering_std_deg, 3.5);
  EXPECT_EQ(settings.sensor.bearing_offset_deg, 0.8);
}

TEST(ReplaySettings, TextReadsBackTheSame) {
  for (const ReplaySettings& settings : {carpark_settings(), mrclam_settings(1), mrclam_settings(3)}) {
    ReplaySettings copy;
    copy.vehicle = settings.vehicle;
    for (const auto& [key, value] : replay_settings_text(settings)) set_replay_setting(copy, key, value);
    const auto text = replay_settings_text(settings), again = replay_settings_text(copy);
    ASSERT_EQ(text.size(), settings.vehicle == VehicleKind::car ? 20U : 24U);
    for (std::size_t i = 0; i < text.size(); ++i) EXPECT_EQ(text[i].value, again[i].value) << text[i].key;
    EXPECT_NO_THROW(check_replay_settings(settings));
  }
}

TEST(ReplaySettings, ErrorsNameKeyValueAndWhatIsAccepted) {
  EXPECT_THAT(error_of("noise.range", "1"), AllOf(HasSubstr("noise.range"), HasSubstr("noise.range_std")));
  EXPECT_THAT(error_of("noise.range_std", "0"), AllOf(HasSubstr("noise.range_std = 0"), HasSubstr("> 0")));
  EXPECT_THAT(error_of("noise.speed_std", "-1"), HasSubstr(">= 0"));
  EXPECT_THAT(error_of("noise.speed_std", "nan"), HasSubstr(">= 0"));
  EXPECT_THAT(error_of("noise.speed_std", "1e999"), HasSubstr(">= 0"));
  EXPECT_THAT(error_of("noise.speed_std", "1 m"), HasSubstr("noise.speed_std = 1 m"));
  EXPECT_THAT(error_of("world.observability", "half"),
              AllOf(HasSubstr("\"partial\""), HasSubstr("\"full\"")));
  EXPECT_THAT(error_of("world.anchors", "1.5"), HasSubstr("whole number"));
  EXPECT_THAT(error_of("filter.gate", "1"), HasSubstr("[0, 1)"));
  EXPECT_THAT(error_of("filter.solution", ""), HasSubstr("min-trace"));
}

TEST(ReplaySettings, AWishThatMeansNothingIsRefused) {
  ReplaySettings car = carpark_settings(), unicycle = mrclam_settings(1);
  EXPECT_THROW(set_replay_setting(car, "noise.turn_rate_std", "1"), std::invalid_argument);
  EXPECT_THROW(set_replay_setting(unicycle, "noise.steering_std_deg", "1"), std::invalid_argument);
  EXPECT_THROW(set_replay_setting(unicycle, "initial.heading_deg", "1"), std::invalid_argument);
  EXPECT_NO_THROW(set_replay_setting(unicycle, "noise.turn_rate_std", "1"));
  for (const char* key : {"filter.jacobians", "sensor.range", "sensor.turn_scale", "truth.heading_std_deg"})
    EXPECT_THROW(set_replay_setting(car, key, "truth"), std::invalid_argument) << key;
  unicycle.filter.association = ReplayAssociation::compatibility;
  unicycle.filter.jacobians = ReplayJacobians::truth;
  EXPECT_THROW(check_replay_settings(unicycle), std::invalid_argument) << "a new landmark has no truth";
}

// Inflation, anchors and own association belong to the EKF of the replay.
TEST(ReplaySettings, OtherEstimatorsRefuseWhatTheyCannot) {
  ReplaySettings settings = mrclam_settings(1);
  set_replay_setting(settings, "filter.estimator", "fej");
  EXPECT_NO_THROW(check_replay_settings(settings));
  EXPECT_THROW(set_replay_setting(settings, "filter.estimator", "magic"), std::invalid_argument);
  for (const auto& [key, value] : {std::pair{"filter.inflation", "map"},
                                   {"world.observability", "full"},
                                   {"filter.association", "compatibility"},
                                   {"filter.jacobians", "truth"}}) {
    ReplaySettings refused = settings;
    set_replay_setting(refused, key, value);
    EXPECT_THROW(check_replay_settings(refused), std::invalid_argument) << key;
    refused.filter.estimator = "ekf";
    EXPECT_NO_THROW(check_replay_settings(refused)) << key;
  }
}

TEST(ReplaySettings, ImpossibleCombinationsAreRefused) {
  ReplaySettings settings;
  settings.noise.range_std = -1;
  EXPECT_THROW(check_replay_settings(settings), std::invalid_argument);
  settings = {};
  settings.world = {.full = true, .anchors = 0};
  EXPECT_THROW(check_replay_settings(settings), std::invalid_argument);
  settings = {};
  settings.filter.association = ReplayAssociation::compatibility;
  EXPECT_THROW(check_replay_settings(settings), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
