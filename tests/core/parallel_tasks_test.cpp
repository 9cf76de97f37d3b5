#include "core/parallel_tasks.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

TEST(ParallelTasks, EachIsDoneOnceOnAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<int> done(1000, 0);
    for_each_task(1000, threads, nullptr, [&](std::int64_t i) { ++done[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(done, std::vector<int>(1000, 1)) << threads;
  }
}

TEST(ParallelTasks, WithoutTasksNothingHappens) {
  for_each_task(0, 3, nullptr, [](std::int64_t) { FAIL(); });
}

TEST(ParallelTasks, AreBegunInTheirOrder) {
  std::mutex mutex;
  std::vector<std::int64_t> begun;
  constexpr int kThreads = 3;
  for_each_task(200, kThreads, nullptr, [&](std::int64_t i) {
    const std::lock_guard lock(mutex);
    begun.push_back(i);
  });
  // A ticket is taken before the lock: no task can be farther ahead than there are threads.
  for (std::size_t at = 0; at < begun.size(); ++at) {
    EXPECT_LT(begun[at], static_cast<std::int64_t>(at) + kThreads);
  }
}

TEST(ParallelTasks, NoFurtherOneIsBegunOnceStopped) {
  std::atomic<bool> stop = false;
  std::atomic<std::int64_t> done = 0;
  for_each_task(1000000, 2, &stop, [&](std::int64_t) {
    if (++done == 10) stop = true;
  });
  EXPECT_GE(done, 10);
  EXPECT_LT(done, 1000);
}

TEST(ParallelTasks, AreEndedAtAStopPointOnceStopped) {
  std::atomic<bool> stop = false;
  std::atomic<int> begun = 0, ended = 0;
  for_each_task(10, 2, &stop, [&](std::int64_t) {
    if (++begun == 1) {
      stop_point();  // nothing yet
      stop = true;
    }
    for (int i = 0; i < 2'000'000'000; ++i) stop_point();
    ++ended;
  });
  EXPECT_GE(begun, 1);
  EXPECT_LE(begun, 2);
  EXPECT_EQ(ended, 0);
}

TEST(ParallelTasks, AStopPointAsksTheInnermostFlag) {
  const std::atomic<bool> set = true, clear = false;
  stop_point();  // outside of any
  const StopScope outer(&set);
  {
    const StopScope inner(&clear);
    stop_point();
    const StopScope none(nullptr);
    stop_point();
  }
  EXPECT_THROW(stop_point(), Stopped);
}

TEST(ParallelTasks, ThrowTheExceptionOfTheLowestTask) {
  std::atomic<std::int64_t> done = 0;
  try {
    for_each_task(1000000, 3, nullptr, [&](std::int64_t i) {
      ++done;
      if (i >= 5) throw std::runtime_error(std::to_string(i));
    });
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), "5");
  }
  EXPECT_LT(done, 1000);
}

#ifndef __has_feature  // as clang tells its sanitizers
#define __has_feature(name) 0
#endif
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !__has_feature(address_sanitizer)
// With sanitizers, which take all addresses, there is no such limit.
// A limit of the memory stands for that of the threads, which does not hold for every user.
TEST(ParallelTasks, FewerThreadsThanWishedAreEnough) {
  const auto under_a_limit = [] {
    const rlimit limit{rlim_t{1} << 30, rlim_t{1} << 30};
    setrlimit(RLIMIT_AS, &limit);
    std::atomic<int> done = 0;
    for_each_task(5000, 4096, nullptr, [&](std::int64_t) { ++done; });
    std::_Exit(done == 5000 ? 0 : 1);
  };
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(under_a_limit(), testing::ExitedWithCode(0), "");
}
#endif

TEST(ParallelTasks, NegativeNumbersOfThreadsAreRefused) {
  for (const int wrong : {-1, 4097}) {
    EXPECT_THROW(thread_count(wrong), std::invalid_argument) << wrong;
    EXPECT_THROW(for_each_task(1, wrong, nullptr, [](std::int64_t) {}), std::invalid_argument) << wrong;
  }
  EXPECT_EQ(thread_count(4096), 4096);
}

TEST(ParallelTasks, ZeroThreadsAreOneForEachProcessor) {
  EXPECT_GE(thread_count(0), 1);
  EXPECT_EQ(thread_count(7), 7);
}

}  // namespace
}  // namespace credence::internal
