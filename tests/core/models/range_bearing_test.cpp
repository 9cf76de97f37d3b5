#include "core/models/range_bearing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace credence::internal {
namespace {

TEST(RangeBearing, OfATriangleByHand) {
  // Sides 3, 4, 5; a vehicle that looks along the second axis sees the landmark atan(3/4) to its right.
  const Pose pose(1.0, 2.0, std::numbers::pi / 2.0);
  const Point landmark(4.0, 6.0);
  const PredictedRangeBearing p = predict_range_bearing(pose, landmark);
  EXPECT_DOUBLE_EQ(p.z[0], 5.0);
  EXPECT_NEAR(p.z[1], -std::atan(3.0 / 4.0), 1e-15);
  Eigen::Matrix<double, 2, 3> H_r;
  H_r << -0.6, -0.8, 0.0, 4.0 / 25.0, -3.0 / 25.0, -1.0;
  EXPECT_LT((p.H_r - H_r).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LT((p.H_l + H_r.leftCols<2>()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(measure_range_bearing(pose, landmark), p.z);
}

TEST(RangeBearing, OfALandmarkBehindIsWrapped) {
  EXPECT_NEAR(measure_range_bearing(Pose(0.0, 0.0, 3.0), Point(-1.0, -0.1))[1],
              std::atan2(-0.1, -1.0) - 3.0 + 2.0 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(measure_range_bearing(Pose(0.0, 0.0, -3.0), Point(-1.0, 0.1))[1],
              std::atan2(0.1, -1.0) + 3.0 - 2.0 * std::numbers::pi, 1e-15);
  EXPECT_DOUBLE_EQ(measure_range_bearing(Pose::Zero(), Point(-2.0, 0.0))[1], std::numbers::pi);
}

TEST(RangeBearing, PlacesALandmarkAllRound) {
  for (int i = 0; i < 16; ++i) {
    const double direction = 2.0 * std::numbers::pi * i / 16.0;
    const Pose pose(-3.0, 0.5, 2.9);
    const Point landmark = pose.head<2>() + 7.0 * Point(std::cos(direction), std::sin(direction));
    const RangeBearing z = measure_range_bearing(pose, landmark);
    EXPECT_NEAR(z[0], 7.0, 1e-14);
    const PlacedLandmark placed = place_landmark(pose, z);
    EXPECT_LT((placed.position - landmark).norm(), 1e-14);
    // h(x, g(x, z)) = z for every x and z, hence H_r + H_l J_r = 0 and H_l J_z = I.
    const PredictedRangeBearing p = predict_range_bearing(pose, landmark);
    EXPECT_LT((p.H_r + p.H_l * placed.J_r).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((p.H_l * placed.J_z - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(RangeBearing, OfALandmarkAtTheVehicleIsNotFinite) {
  const PredictedRangeBearing p = predict_range_bearing(Pose(1.0, 2.0, 0.3), Point(1.0, 2.0));
  EXPECT_EQ(p.z[0], 0.0);
  EXPECT_FALSE(p.H_l.allFinite());
  EXPECT_FALSE(p.H_r.allFinite());
}

TEST(RangeBearing, InnovationTakesTheShortWayRound) {
  for (const double truth : {-3.1, -1.0, 0.0, 3.1}) {
    for (const double error : {-0.2, 0.0, 0.2}) {
      const RangeBearing nu = range_bearing_innovation({2.0, truth + error}, {1.5, truth});
      EXPECT_NEAR(nu[1], error, 1e-14);
      const double other_turn = truth > 0.0 ? truth - 2.0 * std::numbers::pi : truth + 2.0 * std::numbers::pi;
      EXPECT_NEAR(range_bearing_innovation({2.0, truth + error}, {1.5, other_turn})[1], error, 1e-14);
      EXPECT_EQ(nu[0], 0.5);
    }
  }
}

}  // namespace
}  // namespace credence::internal
