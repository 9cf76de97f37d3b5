#include "montecarlo/worlds/planar/planar_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario simulated(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", overrides);
}

TEST(PlanarSimulation, WithoutNoiseItIsTheNominalPathExactlyMeasured) {
  const Scenario scenario = simulated({"world.landmarks=10", "study.steps=500"});
  const PlanarWorld world = make_planar_world(scenario);
  PlanarSimulation simulation(world, PlanarNoise::of(scenario), std::nullopt);
  EXPECT_EQ(simulation.start(5), world.start);
  Pose pose = world.start;
  for (std::size_t k = 1; k <= 50; ++k) {
    simulation.move(k);
    pose = world.vehicle.moved(pose, world.controls[k - 1], world.dt_s);
    ASSERT_EQ(simulation.pose(), pose);
    for (const Observation<PlanarModel>& o : simulation.observe(k)) {
      EXPECT_EQ(o.z, measure_range_bearing(pose, world.landmarks[static_cast<std::size_t>(o.landmark)]));
    }
  }
}

TEST(PlanarSimulation, ItsNoiseIsThatOfTheSourceScaledByTheStandardDeviations) {
  const Scenario scenario = simulated({"world.landmarks=10", "study.steps=500"});
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  const NoiseSource source(3, 4);
  PlanarSimulation simulation(world, noise, source);
  const Pose start = simulation.start(7);
  EXPECT_EQ(start[1], world.start[1] + source.normal(7, 0, NoisePurpose::initial, 1) * noise.initial_std[1]);
  simulation.move(1);
  const Control u(
      world.controls[0][0] + source.normal(7, 1, NoisePurpose::process, 0) * noise.control_std[0],
      world.controls[0][1] + source.normal(7, 1, NoisePurpose::process, 1) * noise.control_std[1]);
  EXPECT_EQ(simulation.pose(), world.vehicle.moved(world.start, u, world.dt_s));
  const auto seen = simulation.observe(1);
  ASSERT_EQ(seen.size(), 10U);
  const RangeBearing exact = measure_range_bearing(simulation.pose(), world.landmarks[6]);
  EXPECT_EQ(seen[6].z[0],
            exact[0] + noise.measurement_std[0] * source.normal(7, 1, NoisePurpose::measurement, 12));
  EXPECT_EQ(seen[6].z[1], wrap_angle(exact[1] + noise.measurement_std[1] *
                                                    source.normal(7, 1, NoisePurpose::measurement, 13)));
}

TEST(PlanarNoise, IsThatOfTheScenarioInItsUnits) {
  const Scenario unicycle =
      simulated({"noise.speed_std=0.3", "noise.turn_rate_std=0.04", "noise.range_std=0.5",
                 "noise.bearing_std_deg=90", "initial.position_std=2", "initial.heading_std_deg=180",
                 "noise.detection_probability=0.7", "noise.measurement_delay=2"});
  const PlanarNoise noise = PlanarNoise::of(unicycle);
  EXPECT_EQ(noise.control_std, Control(0.3, 0.04));
  EXPECT_EQ(noise.measurement_std[0], 0.5);
  EXPECT_DOUBLE_EQ(noise.measurement_std[1], 0.5 * std::numbers::pi);
  EXPECT_EQ(noise.detection_probability, 0.7);
  EXPECT_EQ(noise.measurement_delay, 2);
  Eigen::Matrix3d P0 = Eigen::Vector3d(4.0, 4.0, std::numbers::pi * std::numbers::pi).asDiagonal();
  EXPECT_LT((noise.initial_covariance() - P0).norm(), 1e-14);
  const PlanarNoise steered =
      PlanarNoise::of(simulated({"world.vehicle=bicycle", "noise.steering_std_deg=45"}));
  EXPECT_DOUBLE_EQ(steered.control_std[1], 0.25 * std::numbers::pi);
}

/// What is in range and in the field of view of a pose.
std::vector<int> in_view_of(const PlanarWorld& world, const Pose& pose) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    if (world.sees(measure_range_bearing(pose, world.landmarks[i]))) numbers.push_back(static_cast<int>(i));
  }
  return numbers;
}

std::vector<int> numbers_of(std::span<const Observation<PlanarModel>> seen) {
  std::vector<int> numbers;
  for (const Observation<PlanarModel>& o : seen) numbers.push_back(o.landmark);
  return numbers;
}

TEST(PlanarSimulation, SeesWhatIsInRangeAndFieldOfViewFromWhereItIs) {
  const Scenario scenario =
      simulated({"world.landmarks=40", "world.sensor_range=7", "world.sensor_min_range=3",
                 "world.field_of_view_deg=150", "study.steps=60"});
  const PlanarWorld world = make_planar_world(scenario);
  PlanarSimulation simulation(world, PlanarNoise::of(scenario), NoiseSource(1, 1));
  simulation.start(2);
  std::size_t most = 0, fewest = 40;
  for (std::size_t k = 1; k <= 60; ++k) {
    simulation.move(k);
    const std::vector<int> seen = numbers_of(simulation.observe(k));
    ASSERT_EQ(seen, in_view_of(world, simulation.pose())) << k;
    most = std::max(most, seen.size());
    fewest = std::min(fewest, seen.size());
  }
  EXPECT_GT(most, fewest);
  EXPECT_LT(most, 30U);
}

// 5 standard errors of a share; what is seen is what would be seen without misses, to the last bit.
TEST(PlanarSimulation, EachLandmarkIsMissedByItselfAndTheOthersAreTheSame) {
  const Scenario sure = simulated({"study.steps=200", "world.sensor_range=100"}),
                 missed = simulated(
                     {"study.steps=200", "world.sensor_range=100", "noise.detection_probability=0.6"});
  const PlanarWorld world = make_planar_world(sure);
  PlanarSimulation all(world, PlanarNoise::of(sure), NoiseSource(1, 1)),
      some(world, PlanarNoise::of(missed), NoiseSource(1, 1));
  EXPECT_EQ(all.start(0), some.start(0));
  std::size_t seen = 0, there = 0;
  for (std::size_t k = 1; k <= 200; ++k) {
    all.move(k);
    some.move(k);
    const auto whole = all.observe(k);
    there += whole.size();
    for (const Observation<PlanarModel>& o : some.observe(k)) {
      ++seen;
      ASSERT_EQ(o.z, whole[static_cast<std::size_t>(o.landmark)].z);
    }
  }
  EXPECT_EQ(there, 200 * world.landmarks.size());
  const double share = static_cast<double>(seen) / static_cast<double>(there);
  EXPECT_NEAR(share, 0.6, 5.0 * std::sqrt(0.24 / static_cast<double>(there)));
}

TEST(PlanarSimulation, WhatIsLateIsThatOfStepsBefore) {
  const Scenario prompt = simulated({"study.steps=12"}),
                 late = simulated({"study.steps=12", "noise.measurement_delay=3"});
  const PlanarWorld world = make_planar_world(prompt);
  PlanarSimulation now(world, PlanarNoise::of(prompt), NoiseSource(1, 1)),
      then(world, PlanarNoise::of(late), NoiseSource(1, 1));
  for (std::int64_t run = 0; run < 2; ++run) {  // nothing of a run is left in the next
    now.start(run);
    then.start(run);
    std::vector<std::vector<RangeBearing>> seen(1);
    for (std::size_t k = 1; k <= 12; ++k) {
      now.move(k);
      then.move(k);
      seen.emplace_back();
      for (const auto& o : now.observe(k)) seen.back().push_back(o.z);
      std::vector<RangeBearing> arrived;
      for (const auto& o : then.observe(k)) arrived.push_back(o.z);
      ASSERT_EQ(arrived, k > 3 ? seen[k - 3] : std::vector<RangeBearing>{}) << k;
    }
  }
}

TEST(PlanarSimulation, AngleOfEstimatesAndBearingsAreWrapped) {
  const Scenario scenario =
      simulated({"initial.heading_std_deg=300", "noise.bearing_std_deg=300", "study.steps=1"});
  const PlanarWorld world = make_planar_world(scenario);
  PlanarSimulation simulation(world, PlanarNoise::of(scenario), NoiseSource(1, 1));
  double largest = 0.0;
  for (std::int64_t run = 0; run < 50; ++run) {
    largest = std::max(largest, std::abs(simulation.start(run)[2]));
    simulation.move(1);
    for (const auto& o : simulation.observe(1)) largest = std::max(largest, std::abs(o.z[1]));
  }
  EXPECT_GT(largest, 3.0);
  EXPECT_LE(largest, std::numbers::pi);
}

TEST(RecordPlanarError, IsEstimateLessTruthOfTheLandmarksThatItHas) {
  const PlanarWorld world = make_planar_world(simulated({"world.landmarks=3"}));
  TraceStep step;
  step.landmarks = {2, 0};
  step.estimate = Vector::LinSpaced(7, 1.0, 7.0);
  const Pose pose(0.5, -1.0, -3.0);
  record_planar_error(pose, world, step);
  Vector truth(7);
  truth << pose, world.landmarks[2], world.landmarks[0];
  EXPECT_EQ(step.truth, truth);
  EXPECT_NEAR(step.error[2], 6.0 - 2.0 * std::numbers::pi, 1e-15);
  Vector rest = step.estimate - truth;
  rest[2] = step.error[2];
  EXPECT_EQ(step.error, rest);
  EXPECT_EQ(step.states, (std::vector<Index>{0, 1, 2, 7, 8, 3, 4}));
}

TEST(DescribePlanarWorld, TellsLandmarksFromAnchors) {
  const PlanarWorld world =
      make_planar_world(simulated({"world.landmarks=3", "world.observability=full", "world.anchors=2"}));
  const RunTrace trace = describe_planar_world(world);
  ASSERT_EQ(trace.landmark_positions.cols(), 3);
  ASSERT_EQ(trace.anchor_positions.cols(), 2);
  EXPECT_EQ(Point(trace.landmark_positions.col(2)), world.landmarks[2]);
  EXPECT_EQ(Point(trace.anchor_positions.col(1)), world.landmarks[4]);
  const RunLayout layout = planar_layout(world);
  EXPECT_EQ(layout.states.size(), 9U);
  EXPECT_EQ(layout.sensors.front().dim, 10) << "anchors are measured";
  EXPECT_EQ(layout.sensors.front().angles, (std::vector<bool>{false, true}));
}

}  // namespace
}  // namespace credence::internal
