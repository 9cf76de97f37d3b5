#include "montecarlo/worlds/planar_slam/odometry_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario heard_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

// The truth is the nominal circle; odometry and measurements have the noise that the scenario states.
TEST(OdometrySimulation, NoiseIsThatOfTheScenario) {
  const Scenario s = heard_scenario({"study.steps=400", "noise.speed_std=0.02", "noise.turn_rate_std=0.03",
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

// The slots that the docstring names.
TEST(OdometrySimulation, NoiseIsThatOfTheSource) {
  const OdometryWorld world = make_odometry_world(
      heard_scenario({"initial.position_std=0.3", "initial.heading_std_deg=20", "study.steps=9"}));
  const NoiseSource source(3, 4);
  OdometrySimulation simulation(world, source);
  const Pose start = simulation.start(5);
  for (Index i = 0; i < 3; ++i) {
    const double exact =
        world.path.front()[i] + world.noise.initial_std[i] * source.normal(5, 0, NoisePurpose::initial, i);
    EXPECT_NEAR(start[i], i == 2 ? wrap_angle(exact) : exact, 1e-14);
  }
  for (std::size_t k = 1; k <= 9; ++k) {
    const auto step = static_cast<std::int64_t>(k);
    const Control noise = simulation.read(k) - world.plane.controls[k - 1];
    EXPECT_NEAR(noise[1], world.noise.control_std[1] * source.normal(5, step, NoisePurpose::process, 1),
                1e-14);
    const auto seen = simulation.observe(k);
    ASSERT_EQ(seen.size(), world.in_view[k].size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const auto slot = std::int64_t{2} * seen[i].landmark;
      EXPECT_NEAR(seen[i].z[0] - world.in_view[k][i].z[0],
                  world.noise.measurement_std[0] * source.normal(5, step, NoisePurpose::measurement, slot),
                  1e-13);
    }
  }
}

// A bearing is wrapped; a relative position of more than π metres must not be.
TEST(OdometrySimulation, OnlyBearingsAreWrapped) {
  for (const bool polar : {false, true}) {
    const OdometryWorld world = make_odometry_world(heard_scenario(
        {polar ? "world.landmark_sensor=range_bearing" : "world.landmark_sensor=relative_position",
         polar ? "noise.bearing_std_deg=200" : "noise.relative_position_std=3", "study.steps=30"}));
    OdometrySimulation simulation(world, NoiseSource(1, 1));
    simulation.start(0);
    double largest = 0.0;
    for (std::size_t k = 1; k <= 30; ++k) {
      for (const auto& o : simulation.observe(k)) largest = std::max(largest, std::abs(o.z[1]));
    }
    EXPECT_EQ(largest <= std::numbers::pi, polar) << largest;
  }
}

// 5 standard errors of a share; a measurement that is not missed is that of a world where none is.
TEST(OdometrySimulation, LandmarksAreMissedOneByOneOrLate) {
  const auto world_of = [](const std::vector<std::string>& more) {
    std::vector<std::string> overrides = {"study.steps=100", "world.sensor_range=100"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return make_odometry_world(heard_scenario(overrides));
  };
  const OdometryWorld sure = world_of({}), missed = world_of({"noise.detection_probability=0.3"}),
                      late = world_of({"noise.measurement_delay=2"});
  const NoiseSource source(1, 1);
  OdometrySimulation all(sure, source), some(missed, source), then(late, source);
  for (OdometrySimulation* simulation : {&all, &some, &then}) simulation->start(0);
  std::vector<std::vector<Observation<PlanarModel>>> seen(1);
  std::size_t count = 0;
  for (std::size_t k = 1; k <= 100; ++k) {
    const auto whole = all.observe(k);
    seen.emplace_back(whole.begin(), whole.end());
    for (const auto& o : some.observe(k)) {
      ++count;
      ASSERT_EQ(o.z, whole[static_cast<std::size_t>(o.landmark)].z);
    }
    const auto arrived = then.observe(k);
    ASSERT_EQ(arrived.size(), k > 2 ? seen[k - 2].size() : 0U) << k;
    for (std::size_t i = 0; i < arrived.size(); ++i) ASSERT_EQ(arrived[i].z, seen[k - 2][i].z);
  }
  const double n = 100.0 * static_cast<double>(sure.plane.landmarks.size());
  EXPECT_NEAR(static_cast<double>(count) / n, 0.3, 5.0 * std::sqrt(0.21 / n));
}

}  // namespace
}  // namespace credence::internal
