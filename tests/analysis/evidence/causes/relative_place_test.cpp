#include "analysis/evidence/causes/relative_place.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

TEST(RelativePlace, LiesAheadAndToTheLeft) {
  RelativePlace::State x;
  x << 1.0, 2.0, std::acos(0.0), 0.0, 5.0;  // looks along y: 3 m ahead, 1 m to the left
  EXPECT_NEAR((RelativePlace(x).r - Eigen::Vector2d(3.0, 1.0)).norm(), 0.0, 1e-12);
}

TEST(RelativePlace, IsTheSameToTheBitFromASineAndCosineThatAreKnown) {
  RelativePlace::State x;
  x << 1.0, -2.0, 0.7, 4.0, 5.0;
  const RelativePlace place(x), known(x, place.sine, place.cosine);
  EXPECT_EQ(known.r, place.r);
  EXPECT_EQ(known.sine, place.sine);
  EXPECT_EQ(known.cosine, place.cosine);
  EXPECT_NEAR(place.sine, std::sin(0.7), 1e-15);
}

TEST(RelativePlace, HasTheJacobianOfDifferences) {
  RelativePlace::State x;
  x << 1.0, -2.0, 0.7, 4.0, 5.0;
  constexpr double kStep = 1e-5;
  for (Index i = 0; i < 5; ++i) {
    const RelativePlace::State ahead = x + kStep * RelativePlace::State::Unit(i);
    const RelativePlace::State behind = x - kStep * RelativePlace::State::Unit(i);
    const Eigen::Vector2d slope = (RelativePlace(ahead).r - RelativePlace(behind).r) / (2.0 * kStep);
    EXPECT_NEAR((RelativePlace(x).jacobian().col(i) - slope).norm(), 0.0, 1e-8) << i;
  }
}

}  // namespace
}  // namespace credence::internal
