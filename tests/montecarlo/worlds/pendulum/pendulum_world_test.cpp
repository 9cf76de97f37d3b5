#include "montecarlo/worlds/pendulum/pendulum_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/plugged/plug_check.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

using testing::IsEmpty;

Scenario pendulum(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"pendulum\"\n", "t.toml", overrides);
}

StudyStatistics run(const Scenario& scenario, std::int64_t runs) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{.id = {}, .experiment = experiment.get(), .runs = runs};
  return run_studies({&task, 1}, {.threads = 1}).front().statistics;
}

TEST(PendulumWorld, ItsPlugIsSound) {
  const FunctionModel model = pendulum_model(pendulum());
  const PluggedExperiment experiment(FunctionWorld(model), [&] { return FunctionEkf(model); },
                                     {.steps = 200});
  EXPECT_THAT(experiment.problems(), IsEmpty());
  for (const char* moments : {"jacobian", "sigma_points"}) {
    const auto of_scenario = make_experiment(pendulum({std::string("filter.moments=") + moments}));
    EXPECT_THAT(plug_problems(*of_scenario), IsEmpty()) << moments;
  }
}

// Filters are no part of the world: they meet the same noise. A pendulum that swings little is linear, for
// both filters.
TEST(PendulumWorld, SwingingLittleItIsLinear) {
  const std::vector<std::string> little = {
      "world.start_angle_deg=0",           "initial.angle_std_deg=1",
      "initial.angular_velocity_std=0.02", "noise.angular_acceleration_density=1e-4",
      "noise.displacement_std=0.01",       "study.steps=100"};
  std::vector<std::string> points = little;
  points.emplace_back("filter.moments=sigma_points");
  EXPECT_EQ(noise_group(pendulum(little)), noise_group(pendulum(points)));
  constexpr double kRuns = 1500.0;
  for (const auto& overrides : {little, points}) {
    const StudyStatistics s = run(pendulum(overrides), static_cast<std::int64_t>(kRuns));
    EXPECT_TRUE(s.failures.empty());
    for (const std::size_t k : {0U, 50U, 99U}) {
      EXPECT_NEAR(s.steps[k][Quantity::nees].mean, 2.0, 5.0 * std::sqrt(4.0 / kRuns)) << k;
      EXPECT_NEAR(s.steps[k][Quantity::nis].mean, 1.0, 5.0 * std::sqrt(2.0 / kRuns)) << k;
    }
  }
}

TEST(PendulumWorld, StepsAreMissed) {
  const StudyStatistics s = run(pendulum({"noise.detection_probability=0.5", "study.steps=40"}), 100);
  std::int64_t seen = 0;
  for (const StepStatistics& step : s.steps) seen += step.nis_dof;
  EXPECT_NEAR(static_cast<double>(seen), 2000.0, 5.0 * std::sqrt(1000.0));
}

}  // namespace
}  // namespace credence::internal
