#include "analysis/laws/correlation/group_sums.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

/// Of rows (k, 1), k from 0.
GroupSums counted(Index rows) {
  GroupSums sums;
  for (Index k = 0; k < rows; ++k) sums.next(2) += Vector{{static_cast<double>(k), 1.0}};
  return sums;
}

TEST(GroupSums, EachRowIsAGroupOfItsOwnUntilThereAreTooMany) {
  const GroupSums sums = counted(64);
  EXPECT_EQ(sums.rows_of_group(), 1);
  ASSERT_EQ(sums.groups(), 64);
  EXPECT_EQ(sums.of_group(63), (Vector{{63.0, 1.0}}));
  EXPECT_TRUE(sums.joins());
  EXPECT_FALSE(counted(63).joins());
}

// 64 groups of 16 rows and one of 16 more make 32 of 32, one of 16, of which no row is lost.
TEST(GroupSums, OfALongRunAreJoinedByTwos) {
  const GroupSums sums = counted(64 * 16 + 16);
  EXPECT_EQ(sums.rows(), 1040);
  EXPECT_EQ(sums.rows_of_group(), 32);
  ASSERT_EQ(sums.groups(), 33);
  for (Index g = 0; g < 32; ++g) {
    const double first = 32.0 * static_cast<double>(g);
    EXPECT_EQ(sums.of_group(g), (Vector{{32.0 * first + 31.0 * 16.0, 32.0}})) << g;
  }
  EXPECT_EQ(sums.of_group(32), (Vector{{16.0 * 1024.0 + 15.0 * 8.0, 16.0}}));
  EXPECT_FALSE(sums.begins()) << "the last group has room for sixteen rows";
}

}  // namespace
}  // namespace credence::internal
