#include "montecarlo/worlds/planar_slam/planar_slam_world.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/filters/estimators/estimators.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"
#include "montecarlo/worlds/planar_slam/odometry_bound.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/engine/allocation_count.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario load(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    load(overrides);
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

StudyStatistics run(const Experiment& experiment, std::int64_t runs, int threads) {
  const StudyTask task{.id = {}, .experiment = &experiment, .runs = runs};
  return run_studies({&task, 1}, {.threads = threads}).front().statistics;
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

TEST(PlanarSlamWorld, LandmarksStandWhereTheScenarioSays) {
  const OdometryWorld ring = make_odometry_world(load({"world.path_radius=8", "world.ring_offset=2.5"}));
  ASSERT_EQ(ring.plane.landmarks.size(), 20U);
  for (const Point& p : ring.plane.landmarks) EXPECT_NEAR(p.norm(), 10.5, 1e-12);
  const auto drawn = [](std::vector<std::string> more) {
    more.insert(more.end(), {"world.landmark_layout=annulus", "world.landmarks=2000"});
    return make_odometry_world(load(more)).plane.landmarks;
  };
  double mean = 0.0;
  const std::vector<Point> map = drawn({});
  for (const Point& p : map) {
    EXPECT_TRUE(p.norm() >= 5.0 && p.norm() <= 15.0);
    mean += p.squaredNorm() / 2000.0;
  }
  // r² is uniform between 25 and 225: standard error 200/√(12·2000) = 1.29.
  EXPECT_NEAR(mean, 125.0, 5 * 1.29);
  EXPECT_EQ(drawn({"study.seed=9"}), map);
  EXPECT_NE(drawn({"world.map=2"}), map);
}

// The truth is the nominal circle; odometry and measurements have the noise that the scenario states.
TEST(PlanarSlamWorld, NoiseIsThatOfTheScenario) {
  const Scenario s = load({"study.steps=400", "noise.speed_std=0.02", "noise.turn_rate_std=0.03",
                           "world.dt=1", "noise.relative_position_std=0.2"});
  const OdometryWorld world = make_odometry_world(s);
  for (const Pose& pose : world.path) EXPECT_LT(std::abs(pose.head<2>().norm() - 10.0), 0.3);
  OdometrySimulation simulation(world, NoiseSource(1, 2));
  Moments speed, turn, measured;
  for (std::int64_t r = 0; r < 10; ++r) {
    simulation.start(r);
    for (std::size_t k = 1; k <= 400; ++k) {
      const Control noise = simulation.read(k) - world.plane.controls[k - 1];
      speed.add(noise[0]);
      turn.add(noise[1]);
      for (const auto& o : simulation.observe(k)) {
        const auto exact =
            std::ranges::find(world.in_view[k], o.landmark, &Observation<PlanarModel>::landmark);
        measured.add(o.z[1] - exact->z[1]);
      }
    }
  }
  // Relative standard error of a variance: √(2/n), n = 4000.
  const double se = std::sqrt(2.0 / 4000.0);
  EXPECT_NEAR(speed.variance() / 0.0004, 1.0, 5 * se);
  EXPECT_NEAR(turn.variance() / 0.0009, 1.0, 5 * se);
  ASSERT_GT(measured.count, 4000);
  EXPECT_NEAR(measured.variance() / 0.04, 1.0, 5 * se);
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
      const StudyStatistics one = run(*experiment, 130, 1);
      EXPECT_EQ(one, run(*experiment, 130, 3)) << kind.name;
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
    const StudyStatistics s = run(*experiment, 64, 1);
    EXPECT_TRUE(s.failures.empty()) << kind.name;
    EXPECT_LT(s.steps[0].nees_dof, 64 * 43) << kind.name;
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

// Where the heading is known the world is linear, and its bound is the Kalman filter's P. Observations that
// are missed half the time tell half as much.
TEST(PosteriorBound, IsTheKalmanFilterOfALinearWorld) {
  const std::vector<std::string> known = {"initial.heading_std_deg=0", "noise.turn_rate_std=0",
                                          "study.steps=200"};
  const Scenario s = load(known);
  const OdometryWorld world = make_odometry_world(s);
  const PosteriorBound bound = odometry_bound(world);
  EXPECT_EQ(bound.find("heading")->mean_bound(), 0.0);
  const double position = bound.find("position")->mean_bound();
  const auto filter = scenario_estimator(s, world);
  OdometrySimulation simulation(world, NoiseSource(1, 2));
  filter->reset(simulation.start(0), world.initial_covariance());
  double variance = 0.0;
  for (std::size_t k = 1; k <= 200; ++k) {
    filter->predict(simulation.read(k), world.truth(k));
    filter->update(simulation.observe(k), world.truth(k));
    variance += filter->covariance().diagonal().head<2>().sum() / 200.0;
  }
  EXPECT_NEAR(position, variance, 1e-10 * variance);
  std::vector<std::string> missed = known;
  missed.emplace_back("noise.detection_probability=0.5");
  std::vector<std::string> noisier = known;
  noisier.push_back(fmt::format("noise.relative_position_std={:.17g}", 0.1 * std::sqrt(2.0)));
  const auto position_of = [](const std::vector<std::string>& overrides) {
    return odometry_bound(make_odometry_world(load(overrides))).find("position")->mean_bound();
  };
  const double half = position_of(missed);
  EXPECT_GT(half, 1.05 * position);
  EXPECT_NEAR(half, position_of(noisier), 1e-10 * half);
}

}  // namespace
}  // namespace credence::internal
