#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace credence::internal {

/// The number of threads that a user's wish means: 0 is one for each processor.
int thread_count(int wished);

/// Calls task(i) for i = 0 … count − 1, each once, on thread_count(threads) threads.
///
/// Tasks are begun in their order, so that what is done at any time is a prefix but for the tasks in hand.
/// Once `stop` is set, or a task has thrown, no further one is begun; a task that asks stop_point() is then
/// ended there and counts as not begun. Of several exceptions that of the lowest i is thrown on. All that
/// tasks wrote is visible after the return.
void for_each_task(std::int64_t count, int threads, const std::atomic<bool>* stop,
                   const std::function<void(std::int64_t)>& task);

}  // namespace credence::internal
