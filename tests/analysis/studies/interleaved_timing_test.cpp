#include "analysis/studies/interleaved_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace credence::internal {
namespace {

// Order statistics of a sign test: for n = 15 the interval from the 4th to the 12th covers the median with
// 96.5 %, for n = 9 from the 2nd to the 8th with 96.1 %, for n = 6 the extremes with 96.9 %.
TEST(SummariseTimes, HasTheMedianAndItsDistributionFreeInterval) {
  const auto of = [](int n) {
    std::vector<double> values;
    for (int i = n; i > 0; --i) values.push_back(i);
    return summarise_times(values);
  };
  EXPECT_EQ(of(15).median, 8.0);
  EXPECT_EQ(of(15).lower, 4.0);
  EXPECT_EQ(of(15).upper, 12.0);
  EXPECT_EQ(of(9).lower, 2.0);
  EXPECT_EQ(of(9).upper, 8.0);
  EXPECT_EQ(of(6).median, 3.5);
  EXPECT_EQ(of(6).lower, 1.0);
  EXPECT_EQ(of(6).upper, 6.0);
  EXPECT_EQ(of(1).lower, 1.0);
  EXPECT_THROW(summarise_times({}), std::invalid_argument);
}

TEST(TimeInterleaved, DoesEveryWorkInEveryRoundInAnotherOrder) {
  std::string order;
  const auto work = [&](char name) { return TimedWork{[&order, name](std::int64_t) { order += name; }}; };
  const std::vector<TimedWork> works{work('a'), work('b'), work('c'), work('d')};
  int timings = 0;
  const auto times = time_interleaved(works, {.repetitions = 20, .seconds = 1e-9}, nullptr,
                                      [&](std::int64_t done, std::int64_t total) {
                                        ++timings;
                                        EXPECT_EQ(done, timings);
                                        EXPECT_EQ(total, 4 * 21);  // with the calibration
                                      });
  ASSERT_EQ(times.size(), 4U);
  for (const MeasuredTime& time : times) EXPECT_EQ(time.repetitions.size(), 20U);
  // Behind the calibration every round has each work twice: once to warm up, once timed.
  const std::string timed = order.substr(order.size() - 160);
  bool differ = false;
  for (std::size_t round = 0; round < 20; ++round) {
    std::string once = timed.substr(8 * round, 8);
    differ = differ || once != timed.substr(0, 8);
    std::ranges::sort(once);
    EXPECT_EQ(once, "aabbccdd");
  }
  EXPECT_TRUE(differ);
}

TEST(TimeInterleaved, RepeatsShortWorkUntilItCanBeTimed) {
  std::int64_t most = 0;
  const TimedWork work{[&](std::int64_t n) {
    most = std::max(most, n);
    volatile std::int64_t sink = 0;
    for (std::int64_t i = 0; i < n; ++i) sink = sink + i;
  }};
  time_interleaved({&work, 1}, {.repetitions = 1, .seconds = 1e-3});
  EXPECT_GT(most, 1000);
}

TEST(TimeInterleaved, TimesWholePeriods) {
  std::vector<std::int64_t> calls;
  const TimedWork work{.work = [&](std::int64_t n) { calls.push_back(n); }, .period = 8};
  time_interleaved({&work, 1}, {.repetitions = 3, .seconds = 1e-9});
  for (const std::int64_t n : calls) EXPECT_TRUE(n == 1 || n % 8 == 0) << n;
  EXPECT_EQ(std::ranges::count(calls, 1), 3);  // to warm up
}

TEST(TimeInterleaved, StopsBetweenRoundsAndKeepsWhatIsMeasured) {
  std::atomic<bool> stop = false;
  const TimedWork work{[](std::int64_t) {}};
  const auto times = time_interleaved(
      {&work, 1}, {.repetitions = 10, .seconds = 1e-9}, &stop,
      [&](std::int64_t done, std::int64_t) { stop = done == 4; });  // the first is the calibration
  ASSERT_EQ(times.size(), 1U);
  EXPECT_EQ(times[0].repetitions.size(), 3U);
  EXPECT_TRUE(time_interleaved({&work, 1}, {.repetitions = 10}, &stop).empty());
  EXPECT_THROW(time_interleaved({&work, 1}, {.repetitions = 0}), std::invalid_argument);
}

// A round of large maps takes seconds.
TEST(TimeInterleaved, StopsWithinARoundWhichIsDropped) {
  std::atomic<bool> stop = false;
  std::int64_t timed = 0;
  const std::vector<TimedWork> works(3, TimedWork{[](std::int64_t) {}});
  const auto times = time_interleaved(works, {.repetitions = 10, .seconds = 1e-9}, &stop,
                                      [&](std::int64_t done, std::int64_t) {
                                        timed = done;
                                        stop = done == 7;  // calibration, a round, and one of the next
                                      });
  EXPECT_EQ(timed, 7);
  ASSERT_EQ(times.size(), 3U);
  for (const MeasuredTime& time : times) EXPECT_EQ(time.repetitions.size(), 1U);
}

}  // namespace
}  // namespace credence::internal
