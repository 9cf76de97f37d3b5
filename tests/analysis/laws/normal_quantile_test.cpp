#include "analysis/laws/normal_quantile.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

// Of any table of the normal law.
TEST(NormalQuantile, IsThatOfBothTails) {
  EXPECT_NEAR(normal_quantile_two_sided(0.95), 1.959963984540054, 1e-14);
  EXPECT_NEAR(normal_quantile_two_sided(0.99), 2.5758293035489004, 1e-14);
  EXPECT_EQ(normal_quantile_two_sided(0.0), 0.0);
}

}  // namespace
}  // namespace credence::internal
