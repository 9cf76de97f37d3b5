#include "core/parallel_tasks.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <latch>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "core/stop_point.h"

// Debian's TBB is not instrumented: the thread sanitizer would not see that it joins its workers.
#if defined(__SANITIZE_THREAD__)
#define CREDENCE_OWN_THREADS
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CREDENCE_OWN_THREADS
#endif
#endif

namespace credence::internal {
namespace {

/// As many threads as are wished and can be had. TBB makes its workers in its workers, where a failure ends
/// the process; so it is found out before, once for each larger number.
int possible_threads(int wished) {
  static std::atomic<int> proved = 1;
  if (wished <= proved) return wished;
  std::latch end(1);
  std::vector<std::jthread> made;
  int possible = wished;
  try {
    made.reserve(static_cast<std::size_t>(wished - 1));
    for (int i = 1; i < wished; ++i) made.emplace_back([&] { end.wait(); });
  } catch (const std::system_error&) {  // there is a limit: half of it is left to what the threads need
    possible = 1 + static_cast<int>(made.size()) / 2;
  }
  end.count_down();
  if (possible == wished) proved = wished;
  return possible;
}

/// Runs `work` on this thread and on up to `threads` − 1 of its own, as many as can be had, and waits for
/// all.
void on_own_threads(int threads, const std::function<void()>& work) {
  std::vector<std::jthread> pool;
  try {
    for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  } catch (const std::system_error&) {  // there are no more
  }
  work();
}

/// Runs `work` on so many threads at once, or as many as can be had, and waits for all.
void on_threads(int wished, const std::function<void()>& work) {
  const int threads = possible_threads(wished);
#ifdef CREDENCE_OWN_THREADS
  on_own_threads(threads, work);
#else
  // Near a limit nobody knows beforehand how many TBB can make.
  if (threads < wished) return on_own_threads(threads, work);
  // Allows the arena more workers than processors when the user asks for them.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena(threads).execute([&] {
    tbb::parallel_for(
        0, threads, [&](int) { work(); }, tbb::simple_partitioner());
  });
#endif
}

}  // namespace

int thread_count(int wished) {
  constexpr int kMost = 4096;
  if (wished < 0 || wished > kMost) {
    throw std::invalid_argument("threads = " + std::to_string(wished) +
                                ": accepted are 0 (one for each processor) to " + std::to_string(kMost));
  }
  return wished > 0 ? wished : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

void for_each_task(std::int64_t count, int threads, const std::atomic<bool>* stop,
                   const std::function<void(std::int64_t)>& task) {
  if (count <= 0) return;
  std::atomic<std::int64_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  std::int64_t first_failure = count;
  std::exception_ptr failure;
  const auto may_begin = [&] {
    return !failed.load(std::memory_order_relaxed) &&
           (stop == nullptr || !stop->load(std::memory_order_relaxed));
  };
  on_threads(static_cast<int>(std::min<std::int64_t>(thread_count(threads), count)), [&] {
    while (may_begin()) {
      const std::int64_t i = next++;
      if (i >= count) return;
      try {
        const StopScope scope(stop);
        task(i);
      } catch (const Stopped&) {
        return;
      } catch (...) {
        const std::lock_guard lock(mutex);
        failed = true;
        if (i < first_failure) {
          first_failure = i;
          failure = std::current_exception();
        }
      }
    }
  });
  if (failure) std::rethrow_exception(failure);
}

}  // namespace credence::internal
