#include "core/models/vehicle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace credence::internal {
namespace {

TEST(Vehicle, UnicycleDrivesAlongItsHeading) {
  const Pose moved = Vehicle{}.moved(Pose(1.0, 2.0, std::numbers::pi / 6.0), Control(2.0, -0.5), 0.5);
  EXPECT_NEAR(moved[0], 1.0 + std::sqrt(3.0) / 2.0, 1e-15);
  EXPECT_NEAR(moved[1], 2.5, 1e-15);
  EXPECT_NEAR(moved[2], std::numbers::pi / 6.0 - 0.25, 1e-15);
}

TEST(Vehicle, BicycleDrivesAlongItsFrontWheel) {
  // The front wheel goes 1 m at heading + steering = 90°; the heading turns by sin 30° / B.
  const Vehicle bicycle{VehicleKind::bicycle, {.wheel_base = 2.0}};
  const Pose moved =
      bicycle.moved(Pose(0.0, 0.0, std::numbers::pi / 3.0), Control(2.0, std::numbers::pi / 6.0), 0.5);
  EXPECT_NEAR(moved[0], 0.0, 1e-15);
  EXPECT_NEAR(moved[1], 1.0, 1e-15);
  EXPECT_NEAR(moved[2], std::numbers::pi / 3.0 + 0.25, 1e-15);
}

TEST(Vehicle, CarCarriesItsSensorAsARigidBodyDoes) {
  // Velocity of the sensor: that of the axle, and ω × its lever. The left rear wheel, H beside the axle's
  // middle, goes H ω slower than that in a turn to the left.
  const VehicleGeometry g{.wheel_base = 2.5, .half_track = 0.8, .sensor_ahead = 3.0, .sensor_beside = 0.7};
  const Vehicle car{VehicleKind::car, g};
  const double heading = 0.7, steering = 0.2, wheel_speed = 4.0, dt = 0.01;
  const double curvature = std::tan(steering) / g.wheel_base;
  const double axle_speed = wheel_speed / (1.0 - g.half_track * curvature);
  const double omega = axle_speed * curvature;
  ASSERT_NEAR(axle_speed - omega * g.half_track, wheel_speed, 1e-14);
  const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading)), left(-ahead[1], ahead[0]);
  const Eigen::Vector2d lever = g.sensor_ahead * ahead + g.sensor_beside * left;
  const Eigen::Vector2d velocity = axle_speed * ahead + omega * Eigen::Vector2d(-lever[1], lever[0]);
  const Pose moved = car.moved(Pose(1.0, -2.0, heading), Control(wheel_speed, steering), dt);
  EXPECT_NEAR(moved[0], 1.0 + dt * velocity[0], 1e-14);
  EXPECT_NEAR(moved[1], -2.0 + dt * velocity[1], 1e-14);
  EXPECT_NEAR(moved[2], heading + dt * omega, 1e-14);
}

TEST(Vehicle, ControlForAFullTurnComesBack) {
  // In a turn at 2 m/s and 0.4 rad/s every point keeps its distance from the centre, 5 m to the left.
  constexpr int kSteps = 40'000;
  constexpr double kSpeed = 2.0, kTurn = 0.4, dt = 2.0 * std::numbers::pi / kTurn / kSteps;
  for (const VehicleKind kind : {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car}) {
    const Vehicle vehicle{kind, {}};
    const Control u = vehicle.control_for(kSpeed, kTurn);
    const Pose start(1.0, 2.0, 0.3);
    Pose pose = start;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (int k = 0; k < kSteps; ++k) {
      pose = vehicle.moved(pose, u, dt);
      middle += pose.head<2>() / kSteps;
    }
    // Euler's steps leave the circle by half a step's turn of its circumference.
    EXPECT_LT((pose - start).norm(), 1e-2);
    const VehicleGeometry& g = vehicle.geometry;
    const double axle_radius = kSpeed / kTurn;
    const double radius =
        kind == VehicleKind::car ? std::hypot(axle_radius - g.sensor_beside, g.sensor_ahead) : axle_radius;
    EXPECT_NEAR((start.head<2>() - middle).norm(), radius, 1e-2) << static_cast<int>(kind);
  }
}

TEST(Vehicle, HeadingIsWrapped) {
  for (const VehicleKind kind : {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car}) {
    const Vehicle vehicle{kind, {}};
    const Control u = vehicle.control_for(2.0, 0.5);
    EXPECT_NEAR(vehicle.moved(Pose(0.0, 0.0, 3.1), u, 0.2)[2], 3.2 - 2.0 * std::numbers::pi, 1e-14);
    EXPECT_NEAR(vehicle.moved(Pose(0.0, 0.0, -3.1), u, -0.2)[2], 2.0 * std::numbers::pi - 3.2, 1e-14);
  }
}

}  // namespace
}  // namespace credence::internal
