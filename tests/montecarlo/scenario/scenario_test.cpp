#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_help.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/scenario/world_schema.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Scenario load(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(text, "scenarios/x.toml", overrides);
}

std::string message(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return scenario_refusal([&] { load(text, overrides); });
}

constexpr const char* kMonobot = "[world]\nmodel = \"monobot\"\n";
constexpr const char* kPlanar = "[world]\nmodel = \"planar\"\n";

// The example of the reference page, with every key of a monobot.
constexpr const char* kComplete = R"([world]
model = "monobot"            # a comment
landmarks = 3
observability = "full"
anchors = 2
[noise]
process_variance = 0.2
measurement_variance = 0.3
initial_variance = 4
[filter]
inflation = "map"
solution = "min-trace"
process_scale = 0.5
measurement_scale = 2.0
[study]
runs = 1_000
steps = 0x10
seed = 7
confidence = 0.99
[sweep]
"world.landmarks" = "1:12"
)";

TEST(Scenario, ReadsEveryKeyOfAMonobot) {
  const Scenario s = load(kComplete);
  EXPECT_EQ(s.name, "x");
  EXPECT_EQ(s.world.model, "monobot");
  EXPECT_EQ(s.world.landmarks, 3);
  EXPECT_EQ(s.world.observability, Observability::full);
  EXPECT_EQ(s.world.anchors, 2);
  EXPECT_EQ(s.noise.process_variance, 0.2);
  EXPECT_EQ(s.noise.measurement_variance, 0.3);
  EXPECT_EQ(s.noise.initial_variance, 4.0) << "an integer is a number";
  EXPECT_EQ(s.filter.inflation, FilterInflation::map);
  EXPECT_EQ(s.filter.solution, InflationSolution::min_trace);
  EXPECT_EQ(s.filter.process_scale, 0.5);
  EXPECT_EQ(s.filter.measurement_scale, 2.0);
  EXPECT_EQ(s.study.runs, 1000);
  EXPECT_EQ(s.study.steps, 16);
  EXPECT_EQ(s.study.seed, 7U);
  EXPECT_EQ(s.study.confidence, 0.99);
}

TEST(Scenario, ReadsEveryKeyOfAPlanarWorld) {
  const Scenario s = load(R"([world]
model = "planar"
vehicle = "car"
path = "eight"
path_radius = 20
speed = 2.5
dt = 0.1
sensor_range = 12
field_of_view_deg = 180
[noise]
speed_std = 0.2
steering_std_deg = 5
range_std = 0.3
bearing_std_deg = 2
[initial]
position_std = 0
heading_std_deg = 0.5
[filter]
inflation = "rank"
inflation_rank = 4
inflation_range = "with-vehicle"
inflation_scale = 0.25
)");
  EXPECT_EQ(s.world.vehicle, VehicleKind::car);
  EXPECT_EQ(s.world.path, PathShape::eight);
  EXPECT_EQ(s.world.path_radius, 20.0);
  EXPECT_EQ(s.world.speed, 2.5);
  EXPECT_EQ(s.world.dt, 0.1);
  EXPECT_EQ(s.world.sensor_range, 12.0);
  EXPECT_EQ(s.world.field_of_view_deg, 180.0);
  EXPECT_EQ(s.noise.speed_std, 0.2);
  EXPECT_EQ(s.noise.steering_std_deg, 5.0);
  EXPECT_EQ(s.noise.range_std, 0.3);
  EXPECT_EQ(s.noise.bearing_std_deg, 2.0);
  EXPECT_EQ(s.initial.position_std, 0.0);
  EXPECT_EQ(s.initial.heading_std_deg, 0.5);
  EXPECT_EQ(s.filter.inflation, FilterInflation::rank);
  EXPECT_EQ(s.filter.inflation_rank, 4);
  EXPECT_EQ(s.filter.inflation_range, InflationRange::with_vehicle);
  EXPECT_EQ(s.filter.inflation_scale, 0.25);
}

TEST(Scenario, NeedsNoMoreThanAModel) {
  Scenario expected = default_scenario("monobot");
  expected.name = "x";
  EXPECT_EQ(load(kMonobot), expected);
  EXPECT_EQ(load(kMonobot).world.dt, 1.0);
  EXPECT_EQ(load(kPlanar).world.dt, 0.25);
  EXPECT_EQ(load("[world]\nmodel = \"monobot\"\nobservability = \"full\"\n").world.anchors, 1);
}

TEST(Scenario, OverridesWinOverTheFileAndTheLastWins) {
  const Scenario s =
      load(kComplete, {"study.runs=5", "filter.inflation=full", "filter.solution = \"pairwise\"",
                       "study.runs=6", "noise.process_variance=1e-3", "world.model=monobot"});
  EXPECT_EQ(s.study.runs, 6);
  EXPECT_EQ(s.filter.inflation, FilterInflation::full);
  EXPECT_EQ(s.filter.solution, InflationSolution::pairwise);
  EXPECT_EQ(s.noise.process_variance, 1e-3);
}

// What a switch turns off can be written and changes nothing, so that switches can be swept and overridden.
TEST(Scenario, WhatPlaysNoPartMakesNoDifference) {
  const Scenario plain = load(kMonobot);
  EXPECT_EQ(load(kMonobot, {"world.anchors=3"}), plain);
  EXPECT_EQ(load(kMonobot, {"filter.solution=min-trace"}), plain);
  EXPECT_EQ(configuration_id(load(kMonobot, {"filter.solution=sequential"})), configuration_id(plain));
  EXPECT_EQ(load(kMonobot, {"noise.process_variance=-0.0"}).noise.process_variance, 0.0);
  EXPECT_EQ(canonical_toml(load(kMonobot, {"noise.process_variance=-0.0"})),
            canonical_toml(load(kMonobot, {"noise.process_variance=0"})));
}

TEST(Scenario, CanonicalTextReadsBackTheSame) {
  const std::vector<std::vector<std::string>> cases = {
      {},
      {"world.observability=full", "world.landmarks=0"},
      {"filter.inflation=map", "filter.solution=sequential"},
      {"filter.inflation=map", "filter.solution=drop"},
      {"filter.inflation=rank", "filter.inflation_rank=2", "filter.inflation_range=map"},
      {"noise.process_variance=0.1234567890123456789", "noise.measurement_variance=5e-324"},
      {"noise.process_variance=1.7976931348623157e308", "noise.initial_variance=123456789012345678"},
      {"study.seed=9223372036854775807", "study.confidence=0.94999999999999996"},
      {"world.model=planar"},
      {"world.model=planar", "world.vehicle=bicycle", "world.observability=full", "world.anchors=2"},
      {"world.model=planar", "world.sensor_range=1e9", "world.field_of_view_deg=0.001"},
  };
  for (const auto& overrides : cases) {
    const Scenario s = load(kMonobot, overrides);
    EXPECT_EQ(load(canonical_toml(s)), s) << canonical_toml(s);
    EXPECT_EQ(canonical_toml(load(canonical_toml(s))), canonical_toml(s));
  }
}

TEST(Scenario, CanonicalTextIsFixed) {
  EXPECT_EQ(canonical_toml(load(kMonobot)), R"([world]
model = "monobot"
landmarks = 2
observability = "partial"
[noise]
process_variance = 0.1
measurement_variance = 0.1
initial_variance = 1.0
[filter]
inflation = "none"
process_scale = 1.0
measurement_scale = 1.0
[study]
runs = 200
steps = 100
seed = 1
confidence = 0.95
)");
}

TEST(Scenario, OrderOfKeysInTheFileDoesNotMatter) {
  EXPECT_EQ(load("[study]\nseed = 3\n[world]\nlandmarks = 4\nmodel = \"monobot\"\n"),
            load("[world]\nmodel = \"monobot\"\nlandmarks = 4\n[study]\nseed = 3\n"));
  EXPECT_EQ(load("study.seed = 3\nworld.model = \"monobot\"\n"), load(kMonobot, {"study.seed=3"}));
  EXPECT_EQ(load("\xEF\xBB\xBF[world]\r\nmodel = 'monobot'\r\n"), load(kMonobot));
}

TEST(Scenario, JsonHoldsTheResolvedValues) {
  const auto json = nlohmann::json::parse(scenario_to_json(load(kComplete)));
  EXPECT_EQ(json["name"], "x");
  EXPECT_EQ(json["world"]["landmarks"], 3);
  EXPECT_EQ(json["filter"]["solution"], "min-trace");
  EXPECT_EQ(json["noise"]["initial_variance"], 4.0);
  EXPECT_FALSE(json["world"].contains("vehicle"));
  const auto text = scenario_to_json(load_scenario_text(kMonobot, "bad\xFFname.toml"));
  EXPECT_TRUE(nlohmann::json::accept(text));
}

// Two filters in one sweep see the same noise; more runs extend a configuration.
TEST(Scenario, NoiseGroupAndIdentityDependOnWhatTheySay) {
  const Scenario base = load(kMonobot);
  for (const char* same : {"filter.inflation=full", "filter.process_scale=2", "study.runs=7", "study.seed=2",
                           "noise.detection_probability=1"}) {
    EXPECT_EQ(noise_group(load(kMonobot, {same})), noise_group(base)) << same;
  }
  for (const char* other : {"world.landmarks=3", "noise.process_variance=0.2", "world.observability=full",
                            "noise.detection_probability=0.5"}) {
    EXPECT_NE(noise_group(load(kMonobot, {other})), noise_group(base)) << other;
  }
  for (const char* other : {"initial.position_std=0.1", "noise.range_std=0.2", "world.path=eight"}) {
    EXPECT_NE(noise_group(load(kPlanar, {other})), noise_group(load(kPlanar))) << other;
  }
  for (const char* same : {"study.runs=7", "study.confidence=0.9"}) {
    EXPECT_EQ(configuration_id(load(kMonobot, {same})), configuration_id(base)) << same;
  }
  for (const char* other : {"study.steps=7", "study.seed=2", "filter.inflation=map", "world.landmarks=3"}) {
    EXPECT_NE(configuration_id(load(kMonobot, {other})), configuration_id(base)) << other;
  }
}

// Stored results and seeds stand on these numbers. They are FNV-1a of the text, computed independently:
// python: functools.reduce(lambda h, b: (h ^ b) * 0x100000001b3 % 2**64, text, 0xcbf29ce484222325).
TEST(Scenario, HashesNeverChange) {
  const Scenario base = load(kMonobot);
  EXPECT_EQ(configuration_id(base), "17706e8db6c8eac8");
  EXPECT_EQ(noise_group(base), 16685848723570150699U);
}

TEST(Scenario, EveryKeyHasADefaultThatIsAccepted) {
  for (const ScenarioKey& key : scenario_keys()) {
    EXPECT_FALSE(key.meaning.empty()) << key.path();
    for (const ScenarioKey::Use& use : key.uses) {
      Scenario s = starting_scenario(use.world);
      // What is an array may be left out, which no empty array says.
      if (!key.default_words.empty() && key.path() != "world.model") continue;
      EXPECT_EQ(set_key(key, key_value(key, s), s), "") << key.path();
    }
    EXPECT_EQ(find_scenario_key(key.section, key.name), &key);
  }
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(ScenarioReference, IsWhatTheTableSays) {
  const std::string page = content_of(source_folder() / "docs/scenario.md");
  EXPECT_THAT(page, HasSubstr(scenario_reference()));
  for (const ScenarioKey& key : scenario_keys()) {
    EXPECT_THAT(scenario_help(), HasSubstr("  " + std::string(key.name) + " = "));
  }
}

TEST(ScenarioReference, ItsExamplesAndMessagesAreTrue) {
  const std::string page = content_of(source_folder() / "docs/scenario.md");
  int examples = 0;
  for (std::size_t at = page.find("```toml\n"); at != std::string::npos;
       at = page.find("```toml\n", at + 1)) {
    const std::string example = page.substr(at + 8, page.find("```", at + 8) - at - 8);
    EXPECT_GE(plan_sweep(read_scenario_text(example, "docs/scenario.md")).points.size(), 1U);
    ++examples;
  }
  EXPECT_EQ(examples, 4);
  const auto said = [](const char* text) {
    try {
      load_scenario_text(text, "scenarios/little.toml");
    } catch (const ScenarioError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(page,
              HasSubstr(said("[world]\nmodel = \"monobot\"\n\n\n[noise]\nmeasurement_variance = -1\n")));
  EXPECT_THAT(page, HasSubstr(said("[world]\nmodel = \"monobot\"\nlandmark = 2\n")));
  EXPECT_THAT(page, HasSubstr(message(kMonobot, {"filter.inflation=maps"})));
}

// Settings that their switches turn off are welcome: one writes them all and turns the switches.
TEST(Scenario, AcceptsEveryKeyAtItsDefault) {
  const std::string text = R"([world]
model = "monobot"            # "monobot" | "planar"
landmarks = 2
observability = "partial"    # "partial" | "full"
anchors = 1                  # with "full"; in the plane full observability needs 2
[noise]
process_variance = 0.1
measurement_variance = 0.1
initial_variance = 1.0
[filter]
inflation = "none"
solution = "pairwise"
process_scale = 1.0
measurement_scale = 1.0
[study]
runs = 200
steps = 100
seed = 1
confidence = 0.95
[sweep]
)";
  EXPECT_EQ(load(text), load(kMonobot));
}

struct Hostile {
  const char* text;
  std::vector<std::string> said;  ///< file and line, key, and what is accepted
};

// What a user may get wrong in a file, and what the message must name.
const std::vector<Hostile> kHostile = {
    // clang-format off
    {"", {"scenarios/x.toml: [world] model is missing", "\"monobot\", \"planar\""}},
    {"[world]\nlandmarks = 2\n", {"[world] model is missing", "\"monobot\""}},
    {"[world]\nmodel = \"monobt\"\n", {"x.toml:2: [world] model = \"monobt\"", "\"monobot\", \"planar\"", "did you mean \"monobot\"?"}},
    {"[world]\nmodel = 3\n", {"x.toml:2: [world] model = 3", "one of \"monobot\"", "not the integer 3"}},
    {"[world]\nmodel = [\"monobot\"]\n", {"x.toml:2: [world] model", "one of \"monobot\"", "the array"}},
    {"[world]\nmodel = \"Monobot\"\n", {"x.toml:2:", "did you mean \"monobot\"?"}},
    {"[wrold]\nmodel = \"monobot\"\n", {"x.toml:2: [wrold] model", "unknown section", "[world]?", "[noise]"}},
    {"[wrold]\n[world]\nmodel = \"monobot\"\n", {"x.toml:1: [wrold]", "unknown section", "[world]?"}},
    {"model = \"monobot\"\n", {"x.toml:1: model = \"monobot\"", "no section", "world.model"}},
    {"world = 3\n", {"x.toml:1: world = 3", "[world]"}},
    {"[[world]]\nmodel = \"monobot\"\n", {"x.toml:1: world", "[world]"}},
    {"sweep = \"1:3\"\n[world]\nmodel = \"monobot\"\n", {"x.toml:1: sweep", "[sweep]"}},
    {"[world]\nmodel = \"monobot\"\nlandmark = 2\n", {"x.toml:3: [world] landmark = 2", "did you mean landmarks?", "observability"}},
    {"[world]\nmodel = \"monobot\"\nruns = 2\n", {"x.toml:3: [world] runs = 2", "did you mean study.runs?"}},
    {"[world]\nmodel = \"monobot\"\n\"\" = 2\n", {"x.toml:3: [world]  = 2", "unknown key"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 0\n", {"x.toml:3: [world] landmarks = 0", ">= 1", "partial"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = -1\n", {"x.toml:3: [world] landmarks = -1", "integer from 0 to 1000000"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 1000001\n", {"x.toml:3: [world] landmarks = 1000001", "0 to 1000000"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 99999999999999999999\n", {"x.toml:3:", "broken TOML"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 2.0\n", {"x.toml:3: [world] landmarks = 2.0", "integer", "the number 2.0"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = \"2\"\n", {"x.toml:3: [world] landmarks = \"2\"", "integer", "the string"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = true\n", {"x.toml:3: [world] landmarks = true", "integer", "the boolean"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 2024-01-01\n", {"x.toml:3: [world] landmarks", "integer", "a date or time"}},
    {"[world]\nmodel = \"monobot\"\n[world.landmarks]\na = 1\n", {"x.toml:3: [world] landmarks", "integer", "a table"}},
    {"[world]\nmodel = \"monobot\"\nobservability = \"ful\"\n", {"x.toml:3: [world] observability", "\"partial\", \"full\"", "\"full\"?"}},
    {"[world]\nmodel = \"monobot\"\nobservability = \"full\"\nanchors = 0\n", {"x.toml:4: [world] anchors = 0", ">= 1", "full"}},
    {"[world]\nmodel = \"monobot\"\nspeed = 1\n", {"x.toml:3: [world] speed = 1", "only with world.model = \"planar\"", "landmarks"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nrange_std = 1\n", {"x.toml:4: [noise] range_std = 1", "planar", "process_variance"}},
    {"[world]\nmodel = \"monobot\"\n[initial]\nposition_std = 1\n", {"x.toml:4: [initial] position_std", "planar"}},
    {"[world]\nmodel = \"planar\"\n[noise]\nprocess_variance = 1\n", {"x.toml:4: [noise] process_variance", "monobot", "speed_std"}},
    {"[world]\nmodel = \"planar\"\n[noise]\nsteering_std_deg = 1\n", {"x.toml:4: [noise] steering_std_deg", "bicycle", "turn_rate_std"}},
    {"[world]\nmodel = \"planar\"\nvehicle = \"car\"\n[noise]\nturn_rate_std = 1\n", {"x.toml:5: [noise] turn_rate_std", "unicycle", "steering_std_deg"}},
    {"[world]\nmodel = \"planar\"\nvehicle = \"bike\"\n", {"x.toml:3: [world] vehicle", "\"unicycle\", \"bicycle\", \"car\""}},
    {"[world]\nmodel = \"planar\"\nsensor_range = inf\n", {"x.toml:3: [world] sensor_range = inf", "finite number > 0"}},
    {"[world]\nmodel = \"planar\"\nsensor_range = 5\nsensor_min_range = 5\n", {"x.toml:4: [world] sensor_min_range = 5", "must be < world.sensor_range"}},
    {"[world]\nmodel = \"planar\"\nsensor_range = 0\n", {"x.toml:3: [world] sensor_range = 0", "finite number > 0"}},
    {"[world]\nmodel = \"planar\"\ndt = -0.25\n", {"x.toml:3: [world] dt = -0.25", "finite number > 0"}},
    {"[world]\nmodel = \"planar\"\nfield_of_view_deg = 361\n", {"x.toml:3: [world] field_of_view_deg = 361", "> 0 and <= 360"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\n\n\nmeasurement_variance = -1\n", {"x.toml:6: [noise] measurement_variance = -1: must be a finite number >= 0"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = nan\n", {"x.toml:4: [noise] process_variance = nan", "finite number >= 0"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = -inf\n", {"x.toml:4: [noise] process_variance = -inf", "finite number >= 0"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = 1e999\n", {"x.toml:4: process_variance = 1e999", "broken TOML"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = \"0.1\"\n", {"x.toml:4: [noise] process_variance = \"0.1\"", "finite number >= 0", "the string"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\ndetection_probability = 0\n", {"x.toml:4: [noise] detection_probability = 0", "> 0 and <= 1"}},
    {"[world]\nmodel = \"planar\"\n[noise]\ndetection_probability = 1.1\n", {"x.toml:4: [noise] detection_probability = 1.1", "> 0 and <= 1"}},
    {"[world]\nmodel = \"monobot\"\n[noise]\nprocess_varience = 1\n", {"x.toml:4:", "did you mean process_variance?"}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation = \"maps\"\n", {"x.toml:4: [filter] inflation = \"maps\"", "\"none\", \"full\", \"map\", \"rank\"", "\"map\"?"}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation = \"full\"\nsolution = \"sequential\"\n", {"x.toml:5: [filter] solution", "map", "\"pairwise\", \"min-trace\""}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation = \"full\"\nsolution = \"drop\"\n", {"x.toml:5: [filter] solution", "map", "\"pairwise\", \"min-trace\""}},
    {"[world]\nmodel = \"monobot\"\n[filter]\nsolution = \"min_trace\"\n", {"x.toml:4: [filter] solution", "\"min-trace\"?"}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation_rank = 1\n", {"x.toml:4: [filter] inflation_rank = 1", "filter.inflation = \"rank\""}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation = \"rank\"\ninflation_rank = 4\n", {"x.toml:5: [filter] inflation_rank = 4", "from 0 to 3"}},
    {"[world]\nmodel = \"monobot\"\n[filter]\ninflation = \"rank\"\ninflation_rank = 3\ninflation_range = \"map\"\n", {"x.toml:5: [filter] inflation_rank = 3", "from 0 to 2"}},
    {"[world]\nmodel = \"monobot\"\nlandmarks = 1\n[filter]\ninflation = \"rank\"\ninflation_range = \"difference\"\n", {"x.toml: [filter] inflation_rank = 1 (default)", "from 0 to 0"}},
    {"[world]\nmodel = \"monobot\"\n[filter]\nprocess_scale = 0\n", {"x.toml:4: [filter] process_scale = 0", "> 0"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nruns = 0\n", {"x.toml:4: [study] runs = 0", "integer from 1 to 1000000000"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nruns = 200.0\n", {"x.toml:4: [study] runs = 200.0", "integer"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nsteps = 0\n", {"x.toml:4: [study] steps = 0", "integer from 1 to 10000000"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nseed = -1\n", {"x.toml:4: [study] seed = -1", "integer from 0 to 9223372036854775807"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nconfidence = 1\n", {"x.toml:4: [study] confidence = 1", "0.5", "0.999999"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nconfidence = 95\n", {"x.toml:4: [study] confidence = 95", "0.5", "0.999999"}},
    {"[world]\nmodel = \"monobot\"\n[study]\nconfidence = 0.9999999999999999\n",
     {"x.toml:4: [study] confidence = ", "0.999999"}},
    {"[world]\nmodel = \"monobot\"\nmodel = \"planar\"\n", {"x.toml:3:", "broken TOML", "model"}},
    {"[world]\nmodel = \"monobot\"\n[world]\nlandmarks = 1\n", {"x.toml:3:", "broken TOML", "world"}},
    {"[world\nmodel = \"monobot\"\n", {"x.toml:1:", "broken TOML"}},
    {"[world]\nmodel = monobot\n", {"x.toml:2:", "broken TOML"}},
    {"[world]\nmodel = \"monobot\n", {"x.toml:2:", "broken TOML"}},
    {"[world]\nmodel =\n", {"x.toml:2:", "broken TOML"}},
    {"[world]\nmodel = \"mono\xFF\xFE\"\n", {"x.toml:2:", "broken TOML"}},
    {"{\"world\": {\"model\": \"monobot\"}}\n", {"x.toml:1:", "broken TOML"}},
    {"[world]\nmodel = \"monobot\"\n\"x.y\\nz\" = 1\n", {"x.toml:3:", "unknown key"}},
    // clang-format on
};

TEST(Scenario, RefusesWhatIsWrongNamingPlaceAndRemedy) {
  ASSERT_GE(kHostile.size(), 40U);
  for (const Hostile& hostile : kHostile) {
    const std::string said = message(hostile.text);
    for (const std::string& part : hostile.said) EXPECT_THAT(said, HasSubstr(part)) << hostile.text;
    EXPECT_THAT(said, StartsWith("scenarios/x.toml")) << hostile.text;
    EXPECT_EQ(said.find('\n'), std::string::npos) << "one line: " << said;
    EXPECT_LT(said.size(), 600U) << said;
  }
}

TEST(Scenario, HugeInputIsCutInMessages) {
  const std::string huge(100'000, 'a');
  EXPECT_LT(message(kMonobot, {"filter.inflation=" + huge}).size(), 400U);
  EXPECT_LT(message(kMonobot, {huge}).size(), 400U);
  EXPECT_LT(message("[world]\nmodel = \"" + huge + "\"\n").size(), 400U);
  EXPECT_LT(message("[world]\n" + huge + " = 1\n").size(), 600U);
  EXPECT_LT(message("[" + huge + "]\nx = 1\n").size(), 600U);
  EXPECT_THAT(message(std::string(10'000, '[')), HasSubstr("broken TOML"));
}

}  // namespace
}  // namespace credence::internal
