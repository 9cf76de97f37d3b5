#include "montecarlo/worlds/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/stop_point.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

TEST(Registry, EveryWorldIsComplete) {
  std::set<std::string_view> names;
  for (const World* world : worlds()) {
    EXPECT_TRUE(names.insert(world->schema.name).second) << world->schema.name;
    EXPECT_EQ(find_world(world->schema.name), &world->schema);
    EXPECT_FALSE(world->schema.meaning.empty());
    EXPECT_FALSE(world->schema.keys().empty());
    EXPECT_TRUE(world->linear_problem != nullptr || world->experiment != nullptr) << world->schema.name;
    EXPECT_TRUE(world->schema.blocks != nullptr && world->text != nullptr) << world->schema.name;
    EXPECT_EQ(world->least_doubles == nullptr, world->size_text == nullptr) << world->schema.name;
  }
  EXPECT_EQ(names.size(), 9U);
}

TEST(Registry, AnUnknownWorldIsRefusedByName) {
  EXPECT_EQ(find_world("moon"), nullptr);
  EXPECT_THROW(default_scenario("moon"), std::invalid_argument);
  Scenario scenario;
  scenario.world.model = "moon";
  EXPECT_THROW(world_of(scenario), std::invalid_argument);
  EXPECT_THROW(make_experiment(scenario), std::invalid_argument);
}

// A key of two worlds is one row, with a default of its own in each.
TEST(Registry, WorldsShareKeys) {
  const ScenarioKey* key = find_scenario_key("world", "dt");
  ASSERT_NE(key, nullptr);
  EXPECT_TRUE(key->of_world("planar") && key->of_world("tracking") && key->of_world("planar_slam"));
  EXPECT_FALSE(key->of_world("monobot"));
  EXPECT_EQ(key->accepted_where(),
            "with world.model = \"planar\" or \"tracking\" or \"planar_slam\" or \"localisation\" or "
            "\"inertial\" or \"pendulum\"");
  EXPECT_EQ(real_value(default_scenario("planar"), "world.dt"), 0.25);
  EXPECT_EQ(real_value(default_scenario("tracking"), "world.dt"), 1.0);
  EXPECT_THROW(real_value(Scenario(), "world.model"), std::invalid_argument);
  EXPECT_THROW(real_value(Scenario(), "nonsense"), std::invalid_argument);
}

TEST(Registry, AScenarioIsLinearOrNot) {
  EXPECT_TRUE(linear_problem(default_scenario("monobot")).has_value());
  EXPECT_FALSE(linear_problem(default_scenario("planar")).has_value());
  EXPECT_TRUE(linear_problem(default_scenario("tracking")).has_value());
}

// Errors are shown in them: of each world those of its first states, of a map all others are in m.
TEST(Registry, EveryWorldSaysTheUnitsOfItsStates) {
  struct Case {
    std::string world;
    std::vector<std::string> overrides, units;
  };
  const std::string system = "F = [[1]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n";
  const std::vector<std::string> flat = {"m", "m", "rad"};
  const std::vector<Case> cases = {{"monobot", {}, {"m"}},
                                   {"planar", {}, flat},
                                   {"planar_slam", {}, flat},
                                   {"localisation", {}, flat},
                                   {"spatial_slam", {}, {"m", "m", "m", "rad", "rad", "rad"}},
                                   {"tracking", {}, {"m", "m", "m/s", "m/s"}},
                                   {"tracking", {"world.dimensions=1"}, {"m", "m/s"}},
                                   {"tracking", {"world.dimensions=3"}, {"m", "m", "m", "m/s", "m/s", "m/s"}},
                                   {"tracking", {"world.sensor=range_bearing"}, {"m", "m", "m/s", "m/s"}},
                                   {"pendulum", {}, {"rad", "rad/s"}},
                                   {"inertial",
                                    {},
                                    {"m", "m", "m", "m/s", "m/s", "m/s", "rad", "rad", "rad", "rad/s",
                                     "rad/s", "rad/s", "m/s²", "m/s²", "m/s²"}},
                                   {"linear", {}, {}}};
  std::set<std::string> told;
  for (const auto& [world, overrides, units] : cases) {
    told.insert(world);
    std::vector<std::string> all = overrides;
    all.emplace_back("study.steps=20");
    const std::string text = "[world]\nmodel = \"" + world + "\"\n" + (world == "linear" ? system : "");
    const RunLayout layout = make_experiment(load_scenario_text(text, "t.toml", all))->layout();
    const std::size_t states = layout.states.size();
    std::vector<std::string> expected = units;
    if (std::ranges::find(layout.blocks, Part::map, &Block::part) != layout.blocks.end()) {
      ASSERT_GT(states, units.size()) << world;
      expected.resize(states, "m");
    }
    EXPECT_EQ(layout.units, expected) << world;
    EXPECT_TRUE(layout.units.empty() || layout.units.size() == states) << world;
    for (std::size_t i = 0; i < layout.units.size(); ++i) {
      EXPECT_TRUE(!layout.angles.at(i) || layout.units[i] == "rad") << world << ' ' << layout.states[i];
    }
  }
  for (const World* world : worlds()) EXPECT_TRUE(told.contains(std::string(world->schema.name)));
}

// Ctrl-C is heard within a chunk of runs of every world whose runs are long: those of linear ones, which go
// side by side through lanes, are not.
TEST(Registry, EveryNonlinearWorldCanBeStoppedWithinAChunk) {
  const std::atomic<bool> stop = true;
  for (const World* world : worlds()) {
    if (world->schema.name == "linear") continue;  // has no default matrices
    Scenario scenario = default_scenario(world->schema.name);
    scenario.study.steps = 20;
    if (linear_problem(scenario)) continue;
    const std::unique_ptr<Experiment> experiment = make_experiment(scenario);
    const StopScope scope(&stop);
    EXPECT_THROW(experiment->run_chunk(0, 2), Stopped) << world->schema.name;
    EXPECT_THROW(experiment->visit(0, [](const TraceStep&) {}), Stopped) << world->schema.name;
  }
}

}  // namespace
}  // namespace credence::internal
