#include "core/record/step.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

TEST(AreComplete, WholeObservationsAndNoParts) {
  const auto complete = [](const std::vector<Index>& kept, Index piece) { return are_complete(kept, piece); };
  EXPECT_TRUE(complete({}, 2));
  EXPECT_TRUE(complete({0, 1, 4, 5}, 2));
  EXPECT_TRUE(complete({0, 2, 3}, 1));
  EXPECT_TRUE(complete({3, 4, 5}, 3));
  EXPECT_FALSE(complete({0, 1, 2}, 2)) << "a half";
  EXPECT_FALSE(complete({1, 2}, 2)) << "two halves";
  EXPECT_FALSE(complete({0, 3}, 2)) << "the first half of one and the second of another";
  EXPECT_FALSE(complete({0, 4, 5}, 3));
}

}  // namespace
}  // namespace credence::internal
