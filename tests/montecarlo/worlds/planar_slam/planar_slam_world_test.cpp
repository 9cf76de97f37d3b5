
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/filters/estimators/estimators.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"
#include "montecarlo/worlds/planar_slam/odometry_simulation.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/engine/allocation_count.h"
#include "tests/montecarlo/engine/study_of_runs.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario load(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

std::string refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { load(overrides); });
}

TEST(PlanarSlamWorld, KeysBelongToTheirSwitch) {
  EXPECT_EQ(refusal({"world.ring_offset=2"}), "accepted");
  EXPECT_THAT(refusal({"world.map=2"}), HasSubstr("world.landmark_layout = \"annulus\""));
  EXPECT_EQ(refusal({"world.landmark_layout=annulus", "world.map=2"}), "accepted");
  EXPECT_THAT(refusal({"noise.range_std=2"}), HasSubstr("world.landmark_sensor = \"range_bearing\""));
  EXPECT_EQ(refusal({"world.landmark_sensor=range_bearing", "noise.range_std=2"}), "accepted");
  EXPECT_THAT(refusal({"filter.inflation=map"}), HasSubstr("accepted only with world.model"));
  EXPECT_THAT(refusal({"filter.estimator=invariantt"}), HasSubstr("did you mean \"invariant\"?"));
  EXPECT_THAT(refusal({"world.sensor_min_range=5"}), HasSubstr("must be < world.sensor_range = 5"));
  EXPECT_THAT(refusal({"world.landmarks=0"}), HasSubstr("must be >= 1"));
}

// Estimators are no part of the world: they meet the same noise. The spread of sigma points is of no effect
// where there are none.
TEST(PlanarSlamWorld, EstimatorsShareTheirNoise) {
  const Scenario ekf = load(), ukf = load({"filter.estimator=ukf"});
  EXPECT_EQ(noise_group(ekf), noise_group(ukf));
  EXPECT_NE(configuration_id(ekf), configuration_id(ukf));
  EXPECT_EQ(configuration_id(ekf), configuration_id(load({"filter.sigma_spread=1"})));
  EXPECT_NE(configuration_id(ukf), configuration_id(load({"filter.estimator=ukf", "filter.sigma_spread=1"})));
  for (const char* key : {"filter.window=3", "filter.active_sights=3"}) {
    EXPECT_EQ(configuration_id(ekf), configuration_id(load({key})));
    int concerned = 0;
    for (const EstimatorKind& kind : estimator_kinds()) {
      const std::string estimator = fmt::format("filter.estimator={}", kind.name);
      concerned += configuration_id(load({estimator})) != configuration_id(load({estimator, key})) ? 1 : 0;
    }
    EXPECT_EQ(concerned, std::string(key).starts_with("filter.window") ? 2 : 1) << key;
  }
}

// Every estimator, both sensors: a study is the same bits by one thread and by three, and a visit shows the
// numbers of the chunk.
TEST(PlanarSlamWorld, SameBitsByAnyThreads) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    for (const char* sensor : {"relative_position", "range_bearing"}) {
      const std::size_t steps = kind.name.starts_with("smoother") ? 8 : 30;
      const Scenario s = load({fmt::format("study.steps={}", steps), "filter.window=3",
                               fmt::format("filter.estimator={}", kind.name),
                               fmt::format("world.landmark_sensor={}", sensor)});
      const auto experiment = make_experiment(s);
      const StudyStatistics one = study_of_runs(*experiment, 130, 1);
      EXPECT_EQ(one, study_of_runs(*experiment, 130, 3)) << kind.name;
      const StudyStatistics alone = experiment->run_chunk(7, 1);
      const RunTrace trace = experiment->trace(7);
      ASSERT_EQ(trace.steps.size(), steps + 1) << kind.name;
      EXPECT_EQ(alone.steps[steps - 1][Quantity::nees].mean, trace.steps[steps].nees) << kind.name;
      const TraceStep& last = trace.steps[steps];
      EXPECT_EQ(last.P, Matrix(last.P.transpose()));
      EXPECT_EQ(last.error.size(), last.P.rows());
      EXPECT_EQ(last.K.rows(), last.P.rows());
    }
  }
}

// A start that is known exactly is a singular P: its NEES counts the directions of non-zero variance.
TEST(PlanarSlamWorld, AnExactStartIsLegal) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    const auto experiment =
        make_experiment(load({"study.steps=20", "initial.position_std=0", "initial.heading_std_deg=0",
                              fmt::format("filter.estimator={}", kind.name)}));
    const StudyStatistics s = study_of_runs(*experiment, 64, 1);
    EXPECT_TRUE(s.failures.empty()) << kind.name;
    EXPECT_LT(s.steps[0].nees_dof, 64 * 43) << kind.name;
    // To second order the turn of the first step bends an error of the group out of the range of P.
    const bool bent = kind.name == "invariant";
    if (!bent && kind.name != "ekf") continue;
    EXPECT_EQ(s.steps[0].nees_dof == 0, bent) << kind.name;
    EXPECT_EQ(s.steps[0][Quantity::vehicle_nees].count, bent ? 0 : 64) << kind.name;
    EXPECT_GT(s.steps[1].nees_dof, 0) << kind.name;
  }
}

TEST(PlanarSlamWorld, AStepAllocatesNothing) {
  const Scenario s = load({"study.steps=300"});
  const OdometryWorld world = make_odometry_world(s);
  for (const EstimatorKind& kind : estimator_kinds()) {
    OdometrySimulation simulation(world, NoiseSource(1, 2));
    EstimatorRun estimator(world, scenario_estimator(s, world, kind.name));
    for (std::int64_t r = 0; r < 2; ++r) {
      estimator.start(simulation.start(r));
      const std::int64_t before = allocations_of_this_thread();
      for (std::size_t k = 1; k <= 300; ++k) {
        const Control read = simulation.read(k);
        ASSERT_EQ(estimator.step(k, read, simulation.observe(k)), Outcome::ok);
      }
      if (r > 0) {
        EXPECT_EQ(allocations_of_this_thread() - before, 0) << kind.name;
      }
    }
  }
}

}  // namespace
}  // namespace credence::internal
