// A planar step: where the vehicle drives, what it sees, what the filter and the statistics make of it.

#include <gtest/gtest.h>

#include <string>
#include <utility>

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

TEST(PlanarTraces, AreThePartsOfTheDiagonal) {
  const Matrix P = Vector::LinSpaced(7, 1.0, 7.0).asDiagonal();
  const PlanarTraces traces = planar_traces(P);
  EXPECT_EQ(traces.all, 28.0);
  EXPECT_EQ(traces.position, 3.0);
  EXPECT_EQ(traces.heading, 3.0);
  EXPECT_EQ(traces.landmarks, 22.0);
}

}  // namespace
}  // namespace credence::internal
