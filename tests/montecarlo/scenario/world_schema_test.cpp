#include "montecarlo/scenario/world_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

TEST(WorldSchema, EveryWorldIsFoundByItsName) {
  std::set<std::string_view> names;
  for (const WorldSchema* world : world_schemas()) {
    EXPECT_EQ(find_world(world->name), world);
    EXPECT_TRUE(names.insert(world->name).second) << world->name << " is there twice";
    EXPECT_FALSE(world->meaning.empty());
    EXPECT_NE(world->keys, nullptr);
    EXPECT_NE(world->blocks, nullptr);
  }
  EXPECT_EQ(find_world("Monobot"), nullptr);
  EXPECT_EQ(find_world(""), nullptr);
}

TEST(WorldSchema, ItsDefaultsAreThoseOfAFileThatNamesItAlone) {
  for (const WorldSchema* world : world_schemas()) {
    if (world->name == "linear") continue;  // whose matrices must be given
    Scenario loaded = load_scenario_text("[world]\nmodel = \"" + std::string(world->name) + "\"\n", "t.toml");
    loaded.name.clear();
    EXPECT_EQ(loaded, default_scenario(world->name)) << world->name;
  }
}

// docs/scenario.md: a step of the monobot is 1, the planar default is 0.25 s.
TEST(WorldSchema, AWorldHasDefaultsOfItsOwn) {
  EXPECT_EQ(default_scenario("monobot").world.dt, 1.0);
  EXPECT_EQ(default_scenario("planar").world.dt, 0.25);
}

TEST(WorldSchema, BlocksFollowTheLandmarks) {
  Scenario monobot = default_scenario("monobot"), planar = default_scenario("planar");
  monobot.world.landmarks = planar.world.landmarks = 5;
  EXPECT_EQ(block_layout(monobot).state_dim(), 1 + 5);
  EXPECT_EQ(block_layout(planar).state_dim(), 3 + 2 * 5);
  EXPECT_EQ(block_layout(planar).landmark_offset(4), 11);
}

TEST(WorldSchema, RefusesANameThatNoWorldHas) {
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  EXPECT_THAT([] { default_scenario("moon"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no world is called \"moon\"")));
  Scenario scenario;
  scenario.world.model = "sea";
  EXPECT_THAT([&] { block_layout(scenario); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no world is called \"sea\"")));
}

}  // namespace
}  // namespace credence::internal
