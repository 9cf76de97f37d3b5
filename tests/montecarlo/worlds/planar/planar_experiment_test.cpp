#include "montecarlo/worlds/planar/planar_experiment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
#include <string>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario matrix_scenario(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"world.landmarks=6", "study.steps=40", "world.sensor_range=9"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", overrides);
}

PlanarExperiment<EkfSlam<PlanarModel>> matrix_experiment(const Scenario& s) {
  PlanarWorld world = make_planar_world(s);
  auto make_filter = [filter = make_planar_filter(s, world)] { return filter; };
  return {std::move(world), PlanarNoise::of(s), noise_source(s), std::move(make_filter)};
}

TEST(AssumedPlanarNoise, IsTheTrueOneScaled) {
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(
      matrix_scenario({"noise.speed_std=0.5", "noise.turn_rate_std=0.2", "noise.range_std=0.3",
                       "noise.bearing_std_deg=90", "filter.process_scale=2", "filter.measurement_scale=3"}));
  EXPECT_LT((Matrix(assumed.Q) - Matrix(Eigen::Vector2d(0.5, 0.08).asDiagonal())).norm(), 1e-15);
  EXPECT_NEAR(assumed.measurement_variance[0], 0.27, 1e-15);
  EXPECT_NEAR(assumed.measurement_variance[1], 0.75 * std::numbers::pi * std::numbers::pi, 1e-14);
}

TEST(MakePlanarFilter, KnowsItsAnchors) {
  const Scenario scenario =
      matrix_scenario({"world.observability=full", "world.anchors=2", "world.sensor_range=100"});
  const PlanarWorld world = make_planar_world(scenario);
  EkfSlam<PlanarModel> filter = make_planar_filter(scenario, world);
  filter.reset(world.start, Eigen::Matrix3d::Identity());
  std::vector<Observation<PlanarModel>> seen;
  for (std::size_t i = 6; i < 8; ++i) {
    seen.push_back({static_cast<int>(i), measure_range_bearing(world.start, world.landmarks[i])});
  }
  const UpdateResult update = filter.update(seen);
  EXPECT_EQ(update.dof, 4);
  EXPECT_NEAR(update.nis, 0.0, 1e-12);
  EXPECT_EQ(filter.state().size(), 3) << "an anchor is no state";
  EXPECT_LT(Matrix(filter.covariance()).trace(), 1.0);
}

// Of what a run shows: K = P⁻ Hᵀ S⁻¹ satisfies ΔP = K S Kᵀ, so that the trace falls by tr K S Kᵀ; and NEES
// and NIS are those of its error, P, ν and S.
TEST(PlanarExperiment, WhatIsShownBelongsTogether) {
  const PlanarExperiment experiment = matrix_experiment(matrix_scenario());
  const RunTrace trace = experiment.trace(1);
  ASSERT_EQ(trace.steps.size(), 41U);
  ASSERT_EQ(trace.outcome, Outcome::ok);
  for (const TraceStep& step : trace.steps) {
    const Vector error = step.error;
    if (step.step > 0) {
      EXPECT_NEAR(step.nees, error.dot(step.P.llt().solve(error)), 1e-7 * (1.0 + step.nees));
    }
    EXPECT_NEAR(step.error[2], wrap_angle(step.estimate[2] - step.truth[2]), 1e-15);
    if (step.nis_dof == 0) continue;
    EXPECT_NEAR(step.nis, step.innovation().dot(step.S().llt().solve(step.innovation())),
                1e-8 * (1.0 + step.nis));
    EXPECT_EQ(step.K.cols(), step.innovation().size());
    const StudyStatistics chunk = step.step == 40 ? experiment.run_chunk(1, 1) : StudyStatistics{};
    if (step.step < 40) continue;
    const StepStatistics& last = chunk.steps.back();
    EXPECT_EQ(last[Quantity::nees].mean, step.nees);
    EXPECT_EQ(last[Quantity::nis].mean, step.nis);
    EXPECT_NEAR(last[Quantity::trace].mean, step.P.trace(), 1e-12);
  }
}

TEST(PlanarExperiment, RunsTogetherAreThoseAlone) {
  const PlanarExperiment experiment = matrix_experiment(matrix_scenario());
  std::vector<std::vector<TraceStep>> together(3);
  const std::vector<Outcome> outcomes =
      experiment.visit_runs(5, 3, [&](std::int64_t run, const TraceStep& step) {
        together.at(static_cast<std::size_t>(run - 5)).push_back(step);
      });
  ASSERT_EQ(outcomes.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const RunTrace alone = experiment.trace(5 + static_cast<std::int64_t>(i));
    ASSERT_EQ(together[i].size(), alone.steps.size());
    for (std::size_t k = 0; k < alone.steps.size(); ++k) {
      EXPECT_EQ(together[i][k].estimate, alone.steps[k].estimate);
      EXPECT_EQ(together[i][k].P, alone.steps[k].P);
      EXPECT_EQ(together[i][k].K.size(), 0) << "without the gain";
    }
  }
}

TEST(PlanarExperiment, ARunThatDivergesEndsWithTheStepAtWhichThatWasSeen) {
  const PlanarExperiment experiment = matrix_experiment(matrix_scenario({"initial.position_std=1e6"}));
  const StudyStatistics chunk = experiment.run_chunk(0, 4);
  ASSERT_EQ(chunk.failures.size(), 4U);
  EXPECT_EQ(chunk.failures[2], (RunFailure{2, 1, Outcome::diverged}));
  const RunTrace trace = experiment.trace(2);
  EXPECT_EQ(trace.outcome, Outcome::diverged);
  ASSERT_EQ(trace.steps.size(), 2U);
  EXPECT_EQ(trace.steps[1].nees_dof, 0);
}

}  // namespace
}  // namespace credence::internal
