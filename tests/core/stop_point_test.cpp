#include "core/stop_point.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

using std::chrono::milliseconds;

TEST(StopPoint, ThrowsOnceItsFlagIsSet) {
  std::atomic<bool> stop{false};
  const StopScope scope(&stop);
  stop_point();
  stop = true;
  EXPECT_THROW(stop_point(), Stopped);
  const StopScope inner(nullptr);
  EXPECT_NO_THROW(stop_point()) << "the innermost scope counts";
}

TEST(PulseScope, TellsTheStepsThatWerePassed) {
  std::vector<std::int64_t> told;
  const PulseScope outer([&](std::int64_t steps) { told.push_back(steps); }, milliseconds(0));
  for (int i = 0; i < 130; ++i) stop_point();
  EXPECT_EQ(told, (std::vector<std::int64_t>{64, 64})) << "the clock is not asked at every step";
  stop_point(200);
  EXPECT_EQ(told.back(), 202) << "what was left over as well";
  {
    std::int64_t inside = 0;
    const PulseScope inner([&](std::int64_t steps) { inside += steps; }, milliseconds(0));
    stop_point(70);
    EXPECT_EQ(inside, 70);
  }
  EXPECT_EQ(told.size(), 3u) << "an inner scope keeps its steps to itself";
}

TEST(PulseScope, TellsNotMoreOftenThanOnceInItsInterval) {
  int told = 0;
  const PulseScope scope([&](std::int64_t) { ++told; }, std::chrono::hours(1));
  for (int i = 0; i < 10000; ++i) stop_point();
  EXPECT_EQ(told, 0);
}

}  // namespace
}  // namespace credence::internal
