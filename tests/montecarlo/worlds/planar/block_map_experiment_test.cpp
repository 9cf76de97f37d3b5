// The O(N) filter in the engine: what it is judged by is what the dense form of the same filter is judged by.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/engine/allocation_count.h"

namespace credence::internal {
namespace {

Scenario with_block_map(InflationSolution solution, Index anchors) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 8;
  s.world.sensor_range = 15.0;
  if (anchors > 0) s.world.observability = Observability::full;
  s.world.anchors = anchors;
  s.filter.inflation = FilterInflation::map;
  s.filter.solution = solution;
  s.study.steps = 120;
  return s;
}

void expect_close(const Moments& a, const Moments& b, const char* what) {
  EXPECT_EQ(a.count, b.count) << what;
  EXPECT_NEAR(a.mean, b.mean, 1e-10 * std::abs(b.mean)) << what;
  EXPECT_NEAR(a.m2, b.m2, 1e-8 * std::abs(b.m2) + 1e-20) << what;
}

TEST(BlockMapExperiment, IsJudgedAsTheDenseFormOfTheSameFilter) {
  for (const InflationSolution solution : {InflationSolution::sequential, InflationSolution::drop}) {
    for (const Index anchors : {0, 2}) {
      const Scenario scenario = with_block_map(solution, anchors);
      PlanarWorld world = make_planar_world(scenario);
      const PlanarExperiment<EkfSlam<PlanarModel>> dense(
          world, PlanarNoise::of(scenario), NoiseSource(scenario.study.seed, noise_group(scenario)),
          [filter = make_planar_filter(scenario, world)] { return filter; });
      const StudyStatistics expected = dense.run_chunk(3, 4);
      const StudyStatistics measured = make_experiment(scenario)->run_chunk(3, 4);
      EXPECT_TRUE(expected.failures.empty() && measured.failures.empty());
      for (std::size_t k = 0; k < expected.steps.size(); ++k) {
        const StepStatistics &a = measured.steps[k], &b = expected.steps[k];
        EXPECT_EQ(a.nees_dof, b.nees_dof);
        EXPECT_EQ(a.nis_dof, b.nis_dof);
        for (std::size_t q = 0; q < a.quantities.size(); ++q) {
          expect_close(a.quantities[q], b.quantities[q], "");
        }
      }
    }
  }
}

TEST(BlockMapExperiment, NeesIsThatOfTheDenseMatrixToTwelveDigits) {
  const Scenario scenario = with_block_map(InflationSolution::sequential, 0);
  const RunTrace trace = make_experiment(scenario)->trace(2);
  NeesSolver solver;
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const TraceStep& step = trace.steps[k];
    Vector e = step.estimate - step.truth;
    e[2] = wrap_angle(e[2]);
    const NeesValue dense = joint_nees(e, step.P, solver);
    EXPECT_EQ(step.nees_dof, dense.dof);
    EXPECT_NEAR(step.nees, dense.value, 1e-12 * dense.value);
    if (step.nis_dof > 0) {
      EXPECT_EQ(step.K.cols(), step.nis_dof);
    }
  }
}

TEST(BlockMapExperiment, AStepAllocatesNothingOnceTheMapIsKnown) {
  Scenario scenario = with_block_map(InflationSolution::sequential, 0);
  scenario.study.steps = 500;
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  PlanarSimulation simulation(world, noise, NoiseSource(1, noise_group(scenario)));
  BlockMapEkfSlam<PlanarModel> filter = make_block_map_filter(scenario, world);
  filter.reset(simulation.start(0), noise.initial_covariance());
  StateError error;
  Index most = 0, steps = 0;
  std::int64_t allocations = 0;
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    const std::int64_t before = allocations_of_this_thread();
    simulation.move(k);
    filter.predict(world.controls[k - 1]);
    const UpdateResult update = filter.update(simulation.observe(k));
    ASSERT_EQ(error.compute(simulation.pose(), world.landmarks, filter.state(), filter.covariance(),
                            filter.landmarks()),
              Outcome::ok);
    const Index most_before = std::exchange(most, std::max(most, update.dof));
    // Buffers grow to the most that was ever in view; the loop takes 252 steps.
    if (k <= 252 || update.dof > most_before) continue;
    allocations += allocations_of_this_thread() - before;
    ++steps;
  }
  EXPECT_GT(steps, 200);
  EXPECT_EQ(allocations, 0);
}

TEST(BlockMapExperiment, OnlyASequentialRuleOfTheMapHasABlockMap) {
  Scenario scenario = with_block_map(InflationSolution::sequential, 0);
  EXPECT_TRUE(has_block_map(scenario));
  scenario.filter.solution = InflationSolution::min_trace;
  EXPECT_FALSE(has_block_map(scenario));
  EXPECT_THROW(make_block_map_filter(scenario, make_planar_world(scenario)), std::invalid_argument);
  scenario.filter = {};
  scenario.filter.solution = InflationSolution::sequential;
  EXPECT_FALSE(has_block_map(scenario));
}

}  // namespace
}  // namespace credence::internal
