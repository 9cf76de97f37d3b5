#include "montecarlo/worlds/world_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

Scenario streamed_planar(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", overrides);
}

std::vector<StreamRow> rows_of(const WorldStream& stream, std::int64_t run) {
  std::vector<StreamRow> rows;
  stream.visit(run, [&](std::int64_t step, const StreamRow& row) {
    EXPECT_EQ(step, std::ssize(rows));
    rows.push_back(row);
  });
  return rows;
}

/// What a filter in another program does with a row: each landmark whose numbers are there.
std::vector<Observation<PlanarModel>> observations_of(const Vector& z) {
  std::vector<Observation<PlanarModel>> seen;
  for (Index i = 0; i < z.size() / 2; ++i) {
    if (!std::isnan(z[2 * i])) seen.push_back({static_cast<int>(i), z.segment<2>(2 * i)});
  }
  return seen;
}

// A filter that is fed from the rows alone has the numbers of the filter in the scenario's experiment. More
// than 40 landmarks are run by the matrix filter itself, so that these are its bits.
TEST(PlanarStream, AFilterThatReadsItIsThatOfTheExperiment) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{},
        {"noise.detection_probability=0.6"},
        {"noise.measurement_delay=2"},
        {"world.vehicle=car", "world.observability=full", "world.anchors=2"},
        {"noise.outlier_rate=0.2"}}) {
    std::vector<std::string> overrides = {"world.landmarks=41", "study.steps=15", "world.sensor_range=9",
                                          "filter.process_scale=2"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    const Scenario scenario = streamed_planar(overrides);
    const std::vector<StreamRow> rows = rows_of(world_stream(scenario), 3);
    const RunTrace trace = make_experiment(scenario)->trace(3);
    ASSERT_EQ(rows.size(), 16U);
    ASSERT_EQ(trace.steps.size(), 16U);
    const PlanarWorld world = make_planar_world(scenario);
    auto filter = make_planar_filter(scenario, world);
    filter.reset(Pose(rows[0].prior), PlanarNoise::of(scenario).initial_covariance());
    for (std::size_t k = 1; k < rows.size(); ++k) {
      EXPECT_EQ(rows[k].truth, Vector(trace.steps[k].truth.head(3))) << k;
      EXPECT_EQ(rows[k].prior.size(), 0);
      filter.predict(Control(rows[k].input));
      filter.update(observations_of(rows[k].measurement));
      EXPECT_EQ(filter.state(), trace.steps[k].estimate) << k;
      EXPECT_EQ(filter.covariance(), trace.steps[k].P) << k;
    }
  }
}

TEST(PlanarStream, NamesItsNumbersAndSaysWhereLandmarksStand) {
  const Scenario scenario = streamed_planar({"world.landmarks=2", "study.steps=4"});
  const WorldStream stream = world_stream(scenario);
  EXPECT_THAT(stream.states, testing::ElementsAre("vehicle.x", "vehicle.y", "vehicle.heading"));
  EXPECT_EQ(stream.inputs.size(), 2U);
  EXPECT_THAT(stream.measurements, testing::ElementsAre("landmark1.range", "landmark1.bearing",
                                                        "landmark2.range", "landmark2.bearing"));
  EXPECT_THAT(stream.notes, testing::HasSubstr("landmark2 = "));
  const std::vector<StreamRow> rows = rows_of(stream, 0);
  EXPECT_EQ(rows[0].input.size(), 0);
  EXPECT_EQ(rows[0].measurement.size(), 0);
  EXPECT_EQ(rows[1].measurement.size(), 4);
}

TEST(PlanarStream, ALandmarkThatIsNotSeenHasNoNumbersAndNothingSeenIsEmpty) {
  using Seen = Observation<PlanarModel>;
  EXPECT_EQ(numbers_of_observations(std::span<const Seen>{}, 3).size(), 0);
  const std::vector<Seen> seen = {{2, {5.0, 0.5}}, {0, {1.0, -0.25}}};
  const Vector z = numbers_of_observations(std::span<const Seen>(seen), 3);
  ASSERT_EQ(z.size(), 6);
  EXPECT_EQ(z[0], 1.0);
  EXPECT_EQ(z[1], -0.25);
  EXPECT_TRUE(std::isnan(z[2]) && std::isnan(z[3]));
  EXPECT_EQ(z[4], 5.0);
  EXPECT_EQ(z[5], 0.5);
}

}  // namespace
}  // namespace credence::internal
