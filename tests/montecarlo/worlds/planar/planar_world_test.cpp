#include "montecarlo/worlds/planar/planar_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

Scenario driven_on(PathShape path, double radius = 8.0) {
  Scenario s = default_scenario("planar");
  s.world.path = path;
  s.world.path_radius = radius;
  s.world.speed = 0.5;
  s.world.dt = 0.02;
  s.study.steps = 10'000;
  return s;
}

std::vector<Pose> nominal_path(const PlanarWorld& world) {
  std::vector<Pose> path = {world.start};
  for (const Control& u : world.controls) path.push_back(world.vehicle.moved(path.back(), u, world.dt_s));
  return path;
}

// An Euler step leaves the circle by half a step's length to one side, 5 mm, and closes after 2πr/v.
TEST(PlanarWorld, a_circle_has_its_radius_and_is_driven_anticlockwise) {
  const PlanarWorld world = make_planar_world(driven_on(PathShape::circle));
  EXPECT_LT((world.start - Pose(8.0, 0.0, 0.5 * std::numbers::pi)).norm(), 1e-14);
  const std::vector<Pose> path = nominal_path(world);
  for (const Pose& pose : path) EXPECT_NEAR(pose.head<2>().norm(), 8.0, 0.0101);
  const auto quarter = static_cast<std::size_t>(std::lround(4.0 * std::numbers::pi / 0.01));
  EXPECT_LT((path[quarter].head<2>() - Point(0.0, 8.0)).norm(), 0.02);
  EXPECT_LT((path[4 * quarter].head<2>() - Point(8.0, 0.0)).norm(), 0.05);
}

// Two circles about (0, 8) and (0, −8), the first to the left.
TEST(PlanarWorld, an_eight_is_two_circles_that_touch_in_the_origin) {
  const PlanarWorld world = make_planar_world(driven_on(PathShape::eight));
  EXPECT_LT(world.start.norm(), 1e-14);
  const std::vector<Pose> path = nominal_path(world);
  const auto circle = static_cast<std::size_t>(std::lround(16.0 * std::numbers::pi / 0.01));
  for (std::size_t k = 0; k < path.size(); ++k) {
    const double side = k % (2 * circle) <= circle ? 8.0 : -8.0;
    EXPECT_NEAR((path[k].head<2>() - Point(0.0, side)).norm(), 8.0, 0.03) << k;
  }
  EXPECT_LT((path[circle / 2].head<2>() - Point(0.0, 16.0)).norm(), 0.03);
  EXPECT_LT((path[circle + circle / 2].head<2>() - Point(0.0, -16.0)).norm(), 0.03);
}

TEST(PlanarWorld, a_line_is_driven_forth_and_in_reverse_gear_back) {
  const PlanarWorld world = make_planar_world(driven_on(PathShape::line));
  EXPECT_EQ(world.start, Pose(-8.0, 0.0, 0.0));
  const std::vector<Pose> path = nominal_path(world);
  for (std::size_t k = 0; k < path.size(); ++k) {
    const double s = std::fmod(0.01 * static_cast<double>(k), 32.0);
    EXPECT_NEAR(path[k][0], s < 16.0 ? s - 8.0 : 24.0 - s, 0.011) << k;
    EXPECT_EQ(path[k][1], 0.0);
    EXPECT_EQ(path[k][2], 0.0) << "it never turns";
  }
  EXPECT_EQ(world.controls[0], Control(0.5, 0.0));
  EXPECT_EQ(world.controls[1700], Control(-0.5, 0.0));
}

// 0.3 of the radius inside and outside by turns, at equal angles; the bicycle and the car drive the same
// path.
TEST(PlanarWorld, landmarks_stand_by_turns_inside_and_outside_at_equal_spacing) {
  Scenario s = driven_on(PathShape::circle);
  s.world.observability = Observability::full;
  s.world.landmarks = 6;
  s.world.anchors = 2;
  const PlanarWorld world = make_planar_world(s);
  ASSERT_EQ(world.landmarks.size(), 8U);
  EXPECT_EQ(world.states(), 6);
  for (std::size_t i = 0; i < 8; ++i) {
    // The anchors are the first along the path, and the last by number.
    const std::size_t number = i < 2 ? 6 + i : i - 2;
    const double angle = 2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / 8.0;
    const double radius = i % 2 == 0 ? 0.7 * 8.0 : 1.3 * 8.0;
    const Point expected(radius * std::cos(angle), radius * std::sin(angle));
    EXPECT_LT((world.landmarks[number] - expected).norm(), 1e-12) << i;
  }
}

TEST(PlanarWorld, landmarks_of_the_line_stand_beside_all_of_it) {
  Scenario s = driven_on(PathShape::line);
  s.world.landmarks = 4;
  const std::vector<Point> landmarks = make_planar_world(s).landmarks;
  EXPECT_THAT(landmarks,
              testing::Pointwise(testing::Truly([](const auto& pair) {
                                   return (std::get<0>(pair) - std::get<1>(pair)).norm() < 1e-12;
                                 }),
                                 std::vector<Point>{{-6.0, 2.4}, {-2.0, -2.4}, {2.0, 2.4}, {6.0, -2.4}}));
}

TEST(PlanarWorld, steered_vehicles_drive_the_same_circle) {
  for (const VehicleKind kind : {VehicleKind::bicycle, VehicleKind::car}) {
    Scenario s = driven_on(PathShape::circle);
    s.world.vehicle = kind;
    const PlanarWorld world = make_planar_world(s);
    const std::vector<Pose> path = nominal_path(world);
    const auto circle = static_cast<std::size_t>(std::lround(16.0 * std::numbers::pi / 0.01));
    EXPECT_NEAR(wrap_angle(path[circle / 2][2] - path[0][2] - std::numbers::pi), 0.0, 0.002);
    EXPECT_NEAR(wrap_angle(path[circle][2] - path[0][2]), 0.0, 0.003);
    EXPECT_LT((path[circle].head<2>() - path[0].head<2>()).norm(), 0.1);
  }
}

TEST(PlanarWorld, sees_within_range_and_the_full_angle_of_view) {
  Scenario s = driven_on(PathShape::circle);
  s.world.sensor_min_range = 2.0;
  s.world.sensor_range = 9.0;
  s.world.field_of_view_deg = 90.0;
  const PlanarWorld world = make_planar_world(s);
  EXPECT_TRUE(world.sees({2.0, 0.0}));
  EXPECT_TRUE(world.sees({9.0, 0.0}));
  EXPECT_FALSE(world.sees({1.999, 0.0}));
  EXPECT_FALSE(world.sees({9.001, 0.0}));
  EXPECT_TRUE(world.sees({5.0, 0.2499 * std::numbers::pi}));
  EXPECT_TRUE(world.sees({5.0, -0.2499 * std::numbers::pi}));
  EXPECT_FALSE(world.sees({5.0, 0.2501 * std::numbers::pi}));
  EXPECT_FALSE(world.sees({5.0, -0.2501 * std::numbers::pi}));
}

// A wheel base of 2.83 m: the bicycle's rear wheel cannot drive a circle of 2.8 m.
TEST(PlanarWorld, refuses_a_path_too_tight_for_its_vehicle) {
  Scenario s = driven_on(PathShape::circle, 2.8);
  s.world.vehicle = VehicleKind::bicycle;
  try {
    make_planar_world(s);
    FAIL() << "it drove";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("world.path_radius = 2.8: too tight"));
    EXPECT_THAT(error.what(), testing::HasSubstr("2.83 m"));
  }
  s.world.path_radius = 2.9;
  EXPECT_NO_THROW(make_planar_world(s));
}

}  // namespace
}  // namespace credence::internal
