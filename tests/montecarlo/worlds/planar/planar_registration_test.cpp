
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario registered(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", overrides);
}

enum class Form { lanes, dense, block_map };

Form form_of(const std::vector<std::string>& overrides) {
  const std::unique_ptr<Experiment> experiment = make_experiment(registered(overrides));
  if (dynamic_cast<const PlanarLanesExperiment*>(experiment.get()) != nullptr) return Form::lanes;
  if (dynamic_cast<const PlanarExperiment<BlockMapEkfSlam<PlanarModel>>*>(experiment.get()) != nullptr) {
    return Form::block_map;
  }
  EXPECT_NE(dynamic_cast<const PlanarExperiment<EkfSlam<PlanarModel>>*>(experiment.get()), nullptr);
  return Form::dense;
}

// Maps of up to 40 landmarks run in lanes, where these have the inflation; a sequential rule keeps its map in
// blocks whatever the size.
TEST(PlanarRegistration, TakesTheFormOfTheFilterThatPays) {
  EXPECT_EQ(form_of({"world.landmarks=40"}), Form::lanes);
  EXPECT_EQ(form_of({"world.landmarks=41"}), Form::dense);
  EXPECT_EQ(form_of({"filter.inflation=map"}), Form::lanes);
  EXPECT_EQ(form_of({"filter.inflation=map", "filter.solution=min-trace"}), Form::dense);
  EXPECT_EQ(form_of({"filter.inflation=full"}), Form::dense);
  EXPECT_EQ(form_of({"filter.inflation=rank"}), Form::dense);
  EXPECT_EQ(form_of({"filter.inflation=map", "filter.solution=sequential"}), Form::block_map);
  EXPECT_EQ(form_of({"filter.inflation=map", "filter.solution=sequential", "world.landmarks=60"}),
            Form::block_map);
}

// In every form the layout says what the filter assumes, and whether it inflates.
TEST(PlanarRegistration, TheLayoutSaysWhatTheFilterAssumes) {
  for (const char* landmarks : {"world.landmarks=5", "world.landmarks=45"}) {
    for (const char* inflation : {"filter.inflation=none", "filter.inflation=map"}) {
      const Scenario scenario =
          registered({landmarks, inflation, "noise.range_std=0.5", "filter.measurement_scale=4"});
      const RunLayout layout = make_experiment(scenario)->layout();
      ASSERT_EQ(layout.sensors.size(), 1U);
      ASSERT_EQ(layout.sensors[0].variances.size(), 2U);
      EXPECT_DOUBLE_EQ(layout.sensors[0].variances[0], 1.0);
      EXPECT_EQ(layout.inflated, std::string(inflation) == "filter.inflation=map");
      EXPECT_EQ(layout.states.size(), 3U + 2U * static_cast<std::size_t>(scenario.world.landmarks));
      EXPECT_EQ(layout.landmark_dim, 2);
    }
  }
}

// A dense P over what is seen at the start; a map in blocks of as many landmarks is no trouble.
TEST(PlanarRegistration, ADenseCovarianceThatDoesNotFitIsRefusedNamingItsKey) {
  const std::vector<std::string> large = {"world.landmarks=1000000", "world.sensor_range=1e6",
                                          "study.steps=1"};
  try {
    make_experiment(registered(large));
    FAIL() << "32 TB were there";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("world.landmarks = 1000000, of which 1000000 are seen at the start"));
  }
}

TEST(PlanarRegistration, RefusesASensorThatSeesNothing) {
  const auto said = [](const std::vector<std::string>& overrides) -> std::string {
    return scenario_refusal([&] { registered(overrides); });
  };
  EXPECT_THAT(said({"world.sensor_min_range=30", "world.sensor_range=30"}),
              HasSubstr("must be < world.sensor_range = 30"));
  EXPECT_EQ(said({"world.sensor_min_range=29", "world.sensor_range=30"}), "accepted");
  EXPECT_THAT(said({"world.observability=full", "world.anchors=0"}), HasSubstr("world.anchors=0"));
  EXPECT_THAT(said({"filter.inflation=rank", "filter.inflation_rank=1000"}),
              HasSubstr("filter.inflation_rank"));
}

}  // namespace
}  // namespace credence::internal
