#include "datasets/logs/geodesy.h"

#include <gtest/gtest.h>

#include <numbers>

namespace credence::internal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(Geodesy, TheEquatorAndThePoleAreWhereWgs84PutsThem) {
  EXPECT_LT((earth_fixed({0, 0, 0}) - Eigen::Vector3d(6378137.0, 0, 0)).norm(), 1e-6);
  EXPECT_LT((earth_fixed({90 * kDegree, 0, 0}) - Eigen::Vector3d(0, 0, 6356752.314245)).norm(), 1e-5);
}

TEST(Geodesy, ThereAndBackAgain) {
  for (const double latitude : {-89.9, -45.0, 0.0, 41.4, 80.0}) {
    for (const double height : {-100.0, 0.0, 9000.0}) {
      const Eigen::Vector3d place(latitude * kDegree, 2.1, height);
      const Eigen::Vector3d back = geodetic(earth_fixed(place));
      EXPECT_NEAR(back.x(), place.x(), 1e-10) << latitude;
      EXPECT_NEAR(back.y(), place.y(), 1e-14);
      EXPECT_NEAR(back.z(), place.z(), 1e-4);
    }
  }
}

TEST(Geodesy, NorthIsWhereTheLatitudeGrowsAndUpWhereTheHeightDoes) {
  const Eigen::Vector3d place(0.7, -1.1, 50.0), step(1e-7, 2e-7, 0.3);
  const Eigen::Vector3d moved = east_north_up(place) * (earth_fixed(place + step) - earth_fixed(place));
  EXPECT_GT(moved.x(), 0.0);
  EXPECT_GT(moved.y(), 0.0);
  EXPECT_NEAR(moved.z(), 0.3, 1e-6);
  EXPECT_NEAR((east_north_up(place) * east_north_up(place).transpose() - Eigen::Matrix3d::Identity()).norm(),
              0.0, 1e-14);
}

}  // namespace
}  // namespace credence::internal
