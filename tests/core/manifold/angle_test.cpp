#include "core/manifold/angle.h"

#include <gtest/gtest.h>

#include <limits>

namespace credence::internal {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(WrapAngle, KeepsAnglesWithinTheHalfOpenInterval) {
  EXPECT_EQ(wrap_angle(0.0), 0.0);
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(3.0), 3.0);
}

TEST(WrapAngle, DiffersByWholeTurns) {
  for (int turns = -5; turns <= 5; ++turns) {
    for (double angle = -3.1; angle < 3.1; angle += 0.37) {
      EXPECT_NEAR(wrap_angle(angle + 2.0 * kPi * turns), angle, 1e-14);
    }
  }
}

TEST(Angle, WithinATurnTheWrappedAngleIsTheExactRemainder) {
  for (double angle = -9.5; angle < 9.5; angle += 0.00713) {
    const double remainder = std::remainder(angle, 2.0 * kPi);
    EXPECT_EQ(wrap_angle(angle), remainder) << angle;
  }
  for (const double angle : {std::nextafter(kPi, 4.0), std::nextafter(3.0 * kPi, 0.0)}) {
    EXPECT_EQ(wrap_angle(angle), std::remainder(angle, 2.0 * kPi));
    EXPECT_EQ(wrap_angle(-angle), std::remainder(-angle, 2.0 * kPi));
  }
}

TEST(WrapAngle, LeavesNonFiniteNotFinite) {
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::infinity())));
}

}  // namespace
}  // namespace credence::internal
