#include "core/models/landmark_sensor.h"

#include <gtest/gtest.h>

#include <numbers>

namespace credence::internal {
namespace {

constexpr LandmarkSensorKind kKinds[] = {LandmarkSensorKind::relative_position,
                                         LandmarkSensorKind::range_bearing};

TEST(LandmarkSensor, JacobiansAreThoseOfTheFunctions) {
  for (const LandmarkSensorKind kind : kKinds) {
    const LandmarkSensor sensor{kind};
    const Eigen::Vector2d rho(-1.2, 0.7), z = sensor.measure(rho);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = 1e-6 * Eigen::Vector2d::Unit(i);
      const Eigen::Vector2d by_rho = (sensor.measure(rho + step) - sensor.measure(rho - step)) / 2e-6;
      const Eigen::Vector2d by_z = (sensor.locate(z + step) - sensor.locate(z - step)) / 2e-6;
      EXPECT_LT((sensor.jacobian(rho).col(i) - by_rho).norm(), 1e-8);
      EXPECT_LT((sensor.inverse_jacobian(z).col(i) - by_z).norm(), 1e-8);
    }
    EXPECT_LT((sensor.locate(z) - rho).norm(), 1e-15);
  }
}

TEST(LandmarkSensor, OnlyABearingIsWrapped) {
  const Eigen::Vector2d z(3.0, 3.0), predicted(1.0, -3.0);
  EXPECT_EQ(LandmarkSensor{LandmarkSensorKind::relative_position}.innovation(z, predicted),
            Eigen::Vector2d(2.0, 6.0));
  const Eigen::Vector2d nu = LandmarkSensor{LandmarkSensorKind::range_bearing}.innovation(z, predicted);
  EXPECT_DOUBLE_EQ(nu[1], 6.0 - 2.0 * std::numbers::pi);
}

}  // namespace
}  // namespace credence::internal
