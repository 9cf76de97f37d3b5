#include "montecarlo/engine/task_dispenser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

TEST(TaskDispenser, GivesAQuarterOfTheShareOfWhatIsLeft) {
  TaskDispenser dispenser(
      64, 2, [](std::int64_t) { return true; }, 1000);
  std::vector<std::int64_t> sizes;
  for (TaskRange range; (range = dispenser.next(1, dispenser.guided())).count > 0;)
    sizes.push_back(range.count);
  EXPECT_THAT(sizes,
              ElementsAre(8, 7, 6, 5, 4, 4, 3, 3, 3, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1));
  TaskDispenser near(
      1000, 4, [](std::int64_t) { return true; }, 8);
  EXPECT_EQ(near.guided(), 2) << "8 in all hands together";
}

TEST(TaskDispenser, LeavesOutWhatIsNotWantedAndGivesAgainWhatCameBack) {
  TaskDispenser dispenser(
      10, 2, [](std::int64_t i) { return i != 2 && i != 3; }, 1000);
  EXPECT_EQ(dispenser.next(1, 5).count, 2) << "a range ends before a gap";
  EXPECT_EQ(dispenser.next(0, 1).first, 4);
  EXPECT_FALSE(dispenser.holds(0, 0));
  EXPECT_TRUE(dispenser.holds(1, 0));
  dispenser.done(1, 0);
  EXPECT_FALSE(dispenser.holds(1, 0));
  dispenser.give_back(1);
  EXPECT_TRUE(dispenser.has_returned());
  EXPECT_EQ(dispenser.next(0, 5).first, 1);
  EXPECT_EQ(dispenser.next(0, 9).count, 5);
  EXPECT_EQ(dispenser.next(0, 9).count, 0);
  EXPECT_FALSE(dispenser.all_done());
  for (const std::int64_t task : {1, 4, 5, 6, 7, 8, 9}) dispenser.done(0, task);
  EXPECT_TRUE(dispenser.all_done());
}

TEST(TaskDispenser, KeepsTheFirstTasksForRankZero) {
  TaskDispenser dispenser(
      9, 2, [](std::int64_t i) { return i != 1; }, 1000, 4);
  const auto given = [&](int rank, std::int64_t most) {
    const TaskRange range = dispenser.next(rank, most);
    for (std::int64_t i = 0; i < range.count; ++i) EXPECT_TRUE(dispenser.holds(rank, range.first + i));
    return std::pair(range.first, range.count);
  };
  EXPECT_EQ(given(1, 2), std::pair(4L, 2L));
  EXPECT_EQ(given(0, 9), std::pair(0L, 1L)) << "a range ends before a gap";
  dispenser.give_back(1);
  EXPECT_EQ(given(0, 9), std::pair(2L, 2L)) << "its own before what came back";
  EXPECT_EQ(given(1, 1), std::pair(4L, 1L));
  EXPECT_EQ(given(0, 9), std::pair(5L, 1L));
  EXPECT_EQ(given(0, 2), std::pair(6L, 2L));
  EXPECT_EQ(given(1, 9), std::pair(8L, 1L));
  EXPECT_EQ(dispenser.next(0, 9).count + dispenser.next(1, 9).count, 0);
  EXPECT_FALSE(dispenser.all_done());
  for (const std::int64_t task : {0, 2, 3, 5, 6, 7}) dispenser.done(0, task);
  for (const std::int64_t task : {4, 8}) dispenser.done(1, task);
  EXPECT_TRUE(dispenser.all_done());
}

}  // namespace
}  // namespace credence::internal
