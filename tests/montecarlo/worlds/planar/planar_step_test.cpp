// A planar step: where the vehicle drives, what it sees, what the filter and the statistics make of it.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "tests/montecarlo/engine/allocation_count.h"

namespace credence::internal {
namespace {

Scenario ten_landmarks() {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 10;
  s.study.steps = 500;
  return s;
}

TEST(AllocationCount, SeesWhatEigenAndTheStandardLibraryAllocate) {
  const std::int64_t before = allocations_of_this_thread();
  Matrix M = Matrix::Zero(20, 20);
  std::vector<double> v(100, M(3, 3));
  ASSERT_EQ(v[5], 0.0);
  EXPECT_GE(allocations_of_this_thread() - before, 2);
}

struct Rule {
  FilterInflation inflation;
  InflationSolution solution;
  std::string name;
};

class PlanarStepAllocates : public testing::TestWithParam<Rule> {};

TEST_P(PlanarStepAllocates, NothingOnceTheMapIsKnown) {
  Scenario scenario = ten_landmarks();
  scenario.filter.inflation = GetParam().inflation;
  scenario.filter.solution = GetParam().solution;
  // A short range: what is in view changes along the loop, which takes 252 steps.
  constexpr std::size_t kLoop = 252;
  scenario.world.sensor_range = 15.0;
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  PlanarSimulation simulation(world, noise, NoiseSource(1, noise_group(scenario)));
  EkfSlam<PlanarModel> filter = make_planar_filter(scenario, world);
  filter.reset(simulation.start(0), noise.initial_covariance());
  StateError error;
  StepStatistics statistics;
  Index fewest = 100, most = 0, steps = 0;
  std::int64_t in_first_step = 0, allocations = 0;
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    const std::int64_t before = allocations_of_this_thread();
    simulation.move(k);
    filter.predict(world.controls[k - 1]);
    const UpdateResult update = filter.update(simulation.observe(k));
    ASSERT_EQ(error.compute(simulation.pose(), world.landmarks, filter.state(), filter.covariance(),
                            filter.landmarks()),
              Outcome::ok);
    statistics[Quantity::nees].add(error.nees);
    const std::int64_t made = allocations_of_this_thread() - before;
    if (k == 1) in_first_step = made;
    const Index most_before = std::exchange(most, std::max(most, update.dof));
    if (k <= kLoop) continue;
    fewest = std::min(fewest, update.dof);
    // Buffers grow to the most that was ever in view.
    if (update.dof > most_before) continue;
    allocations += made;
    ++steps;
  }
  EXPECT_EQ(filter.landmarks().size(), 10U);
  EXPECT_LT(fewest, most);
  EXPECT_GT(steps, 200);
  EXPECT_GT(in_first_step, 0);
  EXPECT_EQ(allocations, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, PlanarStepAllocates,
    testing::Values(Rule{FilterInflation::none, InflationSolution::pairwise, "none"},
                    Rule{FilterInflation::full, InflationSolution::pairwise, "full_pairwise"},
                    Rule{FilterInflation::map, InflationSolution::pairwise, "map_pairwise"},
                    Rule{FilterInflation::map, InflationSolution::sequential, "map_sequential"}),
    [](const auto& tested) { return tested.param.name; });

TEST(PlanarSimulation, WithoutNoiseItIsTheNominalPathExactlyMeasured) {
  const Scenario scenario = ten_landmarks();
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
  const Scenario scenario = ten_landmarks();
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

TEST(PlanarTraces, AreThePartsOfTheDiagonal) {
  const Matrix P = Vector::LinSpaced(7, 1.0, 7.0).asDiagonal();
  const PlanarTraces traces = planar_traces(P);
  EXPECT_EQ(traces.all, 28.0);
  EXPECT_EQ(traces.position, 3.0);
  EXPECT_EQ(traces.landmarks, 22.0);
}

}  // namespace
}  // namespace credence::internal
