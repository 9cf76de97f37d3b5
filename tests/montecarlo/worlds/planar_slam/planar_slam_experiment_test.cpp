#include "montecarlo/worlds/planar_slam/planar_slam_experiment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario slam_scenario(const std::vector<std::string>& more) {
  std::vector<std::string> overrides = {"study.steps=30", "world.landmarks=8", "world.sensor_range=6"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

PlanarSlamExperiment slam_experiment(const std::vector<std::string>& more) {
  const Scenario scenario = slam_scenario(more);
  return {scenario, noise_source(scenario)};
}

// Squared errors are those of x̂ − x in every chart; NEES and NIS those of what is shown.
TEST(PlanarSlamExperiment, StatisticsAreThoseOfWhatIsShown) {
  for (const char* estimator : {"filter.estimator=ekf", "filter.estimator=invariant"}) {
    const PlanarSlamExperiment experiment = slam_experiment({estimator});
    const RunTrace trace = experiment.trace(2);
    const StudyStatistics chunk = experiment.run_chunk(2, 1);
    ASSERT_EQ(trace.steps.size(), 31U);
    int silent = 0;
    for (std::size_t k = 1; k <= 30; ++k) {
      const TraceStep& step = trace.steps[k];
      const StepStatistics& s = chunk.steps[k - 1];
      const Vector off = step.estimate - step.truth;
      const double nees = step.error.dot(step.P.llt().solve(step.error));
      EXPECT_NEAR(step.nees, nees, 1e-7 * (1.0 + nees)) << k;
      EXPECT_EQ(step.nees_dof, step.error.size());
      EXPECT_EQ(s[Quantity::nees].mean, step.nees);
      EXPECT_NEAR(s[Quantity::position_error_squared].mean, off.head<2>().squaredNorm(), 1e-12);
      EXPECT_NEAR(s[Quantity::trace].mean, step.P.trace(), 1e-12 * step.P.trace());
      const Index n = off.size();
      if (n > 3) {
        EXPECT_NEAR(s[Quantity::landmark_error_squared].mean,
                    2.0 * off.tail(n - 3).squaredNorm() / static_cast<double>(n - 3), 1e-12);
        const double map = step.P.diagonal().tail(n - 3).sum();
        EXPECT_NEAR(s[Quantity::landmark_variance].mean, 2.0 * map / static_cast<double>(n - 3), 1e-12 * map);
      }
      if (step.nis_dof == 0) {
        ++silent;
        EXPECT_EQ(step.innovation().size(), 0);
        continue;
      }
      EXPECT_EQ(step.innovation().size(), step.nis_dof);
      EXPECT_NEAR(step.nis, step.innovation().dot(step.S().llt().solve(step.innovation())),
                  1e-8 * (1.0 + step.nis));
      EXPECT_EQ(step.K.rows(), n) << "no rows are left out of landmarks just placed";
    }
    EXPECT_LT(silent, 30);
  }
}

// In the plane's chart the error that is judged is the difference; in that of a group it is another.
TEST(PlanarSlamExperiment, TheLayoutSaysTheChartAndTheSensor) {
  for (const bool group : {false, true}) {
    for (const bool polar : {false, true}) {
      const PlanarSlamExperiment experiment = slam_experiment(
          {group ? "filter.estimator=invariant" : "filter.estimator=ekf",
           polar ? "world.landmark_sensor=range_bearing" : "world.landmark_sensor=relative_position",
           polar ? "noise.range_std=0.5" : "noise.relative_position_std=0.5", "filter.measurement_scale=4"});
      const RunLayout& layout = experiment.layout();
      EXPECT_EQ(layout.componentwise, !group);
      EXPECT_EQ(layout.sensors.front().angles, (std::vector<bool>{false, polar}));
      EXPECT_EQ(layout.sensors.front().variances.at(0), 1.0);
      EXPECT_EQ(layout.states.size(), 19U);
      const TraceStep last = experiment.trace(0).steps.back();
      Vector off = last.estimate - last.truth;
      off[2] = std::remainder(off[2], 2.0 * std::acos(-1.0));
      EXPECT_EQ((off - last.error).norm() < 1e-12, !group);
      EXPECT_EQ(experiment.describe_world().landmark_positions.cols(), 8);
    }
  }
}

TEST(PlanarSlamExperiment, ARunThatIsLostIsCountedAndEnds) {
  const PlanarSlamExperiment experiment = slam_experiment({"initial.position_std=1e5"});
  const StudyStatistics chunk = experiment.run_chunk(3, 2);
  ASSERT_EQ(chunk.failures.size(), 2U);
  EXPECT_EQ(chunk.failures[1], (RunFailure{4, 1, Outcome::diverged}));
  EXPECT_EQ(experiment.trace(4).steps.size(), 2U);
  EXPECT_EQ(experiment.trace(4).steps.back().nees_dof, 0);
}

}  // namespace
}  // namespace credence::internal
