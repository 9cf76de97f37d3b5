// Analytic Jacobians of every model against numerical ones, and what the models must satisfy.

#include <gtest/gtest.h>

#include <random>

#include "core/models/range_bearing.h"
#include "core/models/slam_model.h"
#include "core/models/vehicle.h"
#include "tests/core/models/numerical_jacobian.h"

namespace credence::internal {
namespace {

constexpr double kDt = 0.1;

class VehicleJacobian : public testing::TestWithParam<VehicleKind> {};

TEST_P(VehicleJacobian, EqualsTheNumericalOne) {
  const Vehicle vehicle{GetParam(), {}};
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const Pose pose(5.0 * uniform(rng), 5.0 * uniform(rng), 2.5 * uniform(rng));
    const Control u(3.0 * uniform(rng), 0.5 * uniform(rng));
    const Motion motion = vehicle.move(pose, u, kDt);
    const auto of_pose = [&](const Vector& x) { return vehicle.moved(Pose(x), u, kDt); };
    const auto of_control = [&](const Vector& v) { return vehicle.moved(pose, Control(v), kDt); };
    EXPECT_LT((motion.F - numerical_jacobian(of_pose, pose)).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((motion.G - numerical_jacobian(of_control, u)).cwiseAbs().maxCoeff(), 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(AllVehicles, VehicleJacobian,
                         testing::Values(VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car));

TEST(RangeBearing, JacobiansEqualTheNumericalOnes) {
  std::mt19937_64 rng(8);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const Pose pose(5.0 * uniform(rng), 5.0 * uniform(rng), 0.8 * uniform(rng));
    // In front of the vehicle: numerical differences must not cross the wrap of the bearing.
    const Point landmark = pose.head<2>() + Point(6.0 + uniform(rng), 3.0 * uniform(rng));
    const PredictedRangeBearing p = predict_range_bearing(pose, landmark);
    const auto of_pose = [&](const Vector& x) { return measure_range_bearing(Pose(x), landmark); };
    const auto of_landmark = [&](const Vector& l) { return measure_range_bearing(pose, Point(l)); };
    EXPECT_LT((p.H_r - numerical_jacobian(of_pose, pose)).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((p.H_l - numerical_jacobian(of_landmark, landmark)).cwiseAbs().maxCoeff(), 1e-10);

    const RangeBearing z = p.z;
    const PlacedLandmark placed = place_landmark(pose, z);
    EXPECT_LT((placed.position - landmark).norm(), 1e-12) << "g(x, h(x, l)) must be l";
    const auto place_of_pose = [&](const Vector& x) { return place_landmark(Pose(x), z).position; };
    const auto place_of_z = [&](const Vector& v) { return place_landmark(pose, RangeBearing(v)).position; };
    EXPECT_LT((placed.J_r - numerical_jacobian(place_of_pose, pose)).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((placed.J_z - numerical_jacobian(place_of_z, z)).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(RangeBearing, InnovationInTheBearingIsWrapped) {
  const RangeBearing nu = range_bearing_innovation({1.0, 3.1}, {0.5, -3.1});
  EXPECT_NEAR(nu[0], 0.5, 1e-15);
  EXPECT_NEAR(nu[1], 6.2 - 2.0 * std::numbers::pi, 1e-14);
}

TEST(Vehicle, ControlForDrivesAtTheSpeedAndTurnRateAskedFor) {
  for (const VehicleKind kind : {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car}) {
    const Vehicle vehicle{kind, {}};
    const Control u = vehicle.control_for(2.0, 0.3);
    const Pose moved = vehicle.moved(Pose::Zero(), u, 0.01);
    EXPECT_NEAR(moved[2], 0.003, 1e-12);
  }
}

TEST(Vehicle, CarWithSensorOnTheAxleIsABicycleOfTheSameTurn) {
  Vehicle car{VehicleKind::car, {}};
  car.geometry.sensor_ahead = car.geometry.sensor_beside = 0.0;
  const Pose moved = car.moved(Pose(1.0, 2.0, 0.4), car.control_for(2.0, 0.3), kDt);
  EXPECT_LT((moved - Pose(1.0 + 0.2 * std::cos(0.4), 2.0 + 0.2 * std::sin(0.4), 0.43)).norm(), 1e-12);
}

TEST(MonobotModel, JacobiansAreThoseOfItsLinearForm) {
  const auto motion = MonobotModel::move(MonobotModel::Scalar(2.0), MonobotModel::Scalar(0.5));
  EXPECT_EQ(motion.pose[0], 2.5);
  EXPECT_EQ(MonobotModel::predict(MonobotModel::Scalar(2.0), MonobotModel::Scalar(5.0)).z[0], 3.0);
  EXPECT_EQ(MonobotModel::place(MonobotModel::Scalar(2.0), MonobotModel::Scalar(3.0)).position[0], 5.0);
}

}  // namespace
}  // namespace credence::internal
