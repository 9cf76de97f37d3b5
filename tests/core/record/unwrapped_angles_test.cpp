#include "core/record/unwrapped_angles.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(UnwrappedAngles, AreBeyondHalfATurn) {
  constexpr double kHalfTurn = std::numbers::pi;
  EXPECT_FALSE(is_unwrapped(kHalfTurn));
  EXPECT_FALSE(is_unwrapped(-kHalfTurn * (1.0 + 1e-13))) << "a difference of rounded angles";
  EXPECT_TRUE(is_unwrapped(3.15));
  EXPECT_TRUE(is_unwrapped(-6.0));
}

TEST(UnwrappedAngles, AreCountedInEachPiece) {
  Vector nu(6);
  nu << 9.0, 4.0, 9.0, 1.0, 9.0, -4.0;
  EXPECT_EQ(count_unwrapped(nu, {false, true}), 2);
  EXPECT_EQ(count_unwrapped(nu, {true, false}), 3);
  EXPECT_EQ(count_unwrapped(nu, {}), 0);
}

}  // namespace
}  // namespace credence::internal
