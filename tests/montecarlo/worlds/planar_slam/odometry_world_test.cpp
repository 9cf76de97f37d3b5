#include "montecarlo/worlds/planar_slam/odometry_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario odometry_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

TEST(OdometryWorld, LandmarksStandWhereTheScenarioSays) {
  const OdometryWorld ring =
      make_odometry_world(odometry_scenario({"world.path_radius=8", "world.ring_offset=2.5"}));
  ASSERT_EQ(ring.plane.landmarks.size(), 20U);
  for (const Point& p : ring.plane.landmarks) EXPECT_NEAR(p.norm(), 10.5, 1e-12);
  const auto drawn = [](std::vector<std::string> more) {
    more.insert(more.end(), {"world.landmark_layout=annulus", "world.landmarks=2000"});
    return make_odometry_world(odometry_scenario(more)).plane.landmarks;
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

// r² is uniform between those of the two circles, the inner one a point where the annulus is wider than the
// path; angles are uniform: their mean direction has a standard error of 1/√(2n) a coordinate.
TEST(OdometryWorld, AnAnnulusWiderThanItsPathIsADisk) {
  const OdometryWorld world =
      make_odometry_world(odometry_scenario({"world.landmark_layout=annulus", "world.landmarks=2000",
                                             "world.path_radius=4", "world.annulus_half_width=6"}));
  double least = 1e9, most = 0.0;
  Point direction = Point::Zero();
  for (const Point& p : world.plane.landmarks) {
    least = std::min(least, p.norm());
    most = std::max(most, p.norm());
    direction += p.normalized() / 2000.0;
  }
  EXPECT_LT(least, 1.0);
  EXPECT_LE(most, 10.0);
  EXPECT_GT(most, 9.9);
  EXPECT_LT(direction.cwiseAbs().maxCoeff(), 5.0 / std::sqrt(2.0 * 2000.0));
  EXPECT_DOUBLE_EQ(world.width_m, 2.0 * most);
}

TEST(OdometryWorld, ARingBeginsOnTheAxisAtEqualAngles) {
  const OdometryWorld world = make_odometry_world(
      odometry_scenario({"world.path_radius=8", "world.ring_offset=2", "world.landmarks=8"}));
  for (std::size_t i = 0; i < 8; ++i) {
    const double angle = 0.25 * std::numbers::pi * static_cast<double>(i);
    EXPECT_LT((world.plane.landmarks[i] - 10.0 * Point(std::cos(angle), std::sin(angle))).norm(), 1e-12) << i;
  }
  EXPECT_EQ(world.plane.states(), 8) << "all of them are states";
  EXPECT_DOUBLE_EQ(world.width_m, 20.0);
}

// The path is that of the controls; what is in view at a step is what the sensor says of it, by either
// sensor.
TEST(OdometryWorld, SeesFromItsPathWhatIsInRange) {
  for (const char* sensor : {"relative_position", "range_bearing"}) {
    const OdometryWorld world = make_odometry_world(odometry_scenario(
        {std::string("world.landmark_sensor=") + sensor, "world.sensor_range=6", "study.steps=40"}));
    ASSERT_EQ(world.path.size(), 41U);
    ASSERT_EQ(world.in_view.size(), 41U);
    std::size_t seen = 0;
    for (std::size_t k = 0; k <= 40; ++k) {
      const Pose& pose = world.path[k];
      if (k > 0) {
        EXPECT_EQ(pose, world.plane.vehicle.moved(world.path[k - 1], world.plane.controls[k - 1],
                                                  world.plane.dt_s));
        EXPECT_EQ(world.truth(k).before, world.path[k - 1]);
      }
      EXPECT_EQ(world.truth(k).now, pose);
      std::size_t in_range = 0;
      for (std::size_t i = 0; i < world.plane.landmarks.size(); ++i) {
        const Point d = world.plane.landmarks[i] - pose.head<2>();
        if (d.norm() > 6.0) continue;
        ASSERT_LT(in_range, world.in_view[k].size());
        const auto& o = world.in_view[k][in_range++];
        EXPECT_EQ(o.landmark, static_cast<int>(i));
        const double c = std::cos(pose[2]), s = std::sin(pose[2]);
        const Point rho(c * d[0] + s * d[1], c * d[1] - s * d[0]);
        const bool polar = std::string(sensor) == "range_bearing";
        const Point z = polar ? Point(rho.norm(), std::atan2(rho[1], rho[0])) : rho;
        EXPECT_LT((o.z - z).norm(), 1e-12);
        ++seen;
      }
      EXPECT_EQ(in_range, world.in_view[k].size()) << k;
    }
    EXPECT_GT(seen, 40U);
    EXPECT_EQ(world.truth(0).before, world.path[0]);
  }
}

TEST(EstimatorSettings, AreWhatTheFilterBelieves) {
  const Scenario scenario =
      odometry_scenario({"world.landmark_sensor=range_bearing", "noise.range_std=0.5",
                         "noise.bearing_std_deg=9", "noise.speed_std=0.3", "noise.turn_rate_std=0.2",
                         "filter.process_scale=4", "filter.measurement_scale=9", "world.dt=0.5",
                         "filter.estimator=smoother", "filter.window=7", "world.landmarks=5"});
  const OdometryWorld world = make_odometry_world(scenario);
  const EstimatorSettings settings = estimator_settings(scenario, world);
  const double bearing = 0.05 * std::numbers::pi;
  EXPECT_LT((Matrix(settings.Q) - Matrix(Eigen::Vector2d(0.36, 0.16).asDiagonal())).norm(), 1e-15);
  EXPECT_LT((Matrix(settings.R) - Matrix(Eigen::Vector2d(2.25, 9.0 * bearing * bearing).asDiagonal())).norm(),
            1e-15);
  EXPECT_EQ(settings.model.dt_s, 0.5);
  EXPECT_EQ(settings.landmarks, 5);
  EXPECT_EQ(settings.window, 7);
  EXPECT_EQ(settings.sensor.kind, LandmarkSensorKind::range_bearing);
  EXPECT_LT((world.noise.control_std - Control(0.3, 0.2)).norm(), 1e-15) << "the truth keeps its own";
  EXPECT_THROW(scenario_estimator(scenario, world, "none of them"), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
