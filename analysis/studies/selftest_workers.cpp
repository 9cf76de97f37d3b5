#include "analysis/studies/selftest_workers.h"

#include "core/parallel_tasks.h"

namespace credence {

void SelftestWorkers::for_each(std::int64_t count, const std::function<void(std::int64_t)>& work) {
  for_each_task(count, options_.threads, options_.stop, [&](std::int64_t i) {
    work(i);
    const std::lock_guard lock(mutex_);
    ++done_;
    if (options_.progress) options_.progress(done_, total_);
  });
}

bool SelftestWorkers::stopped() const {
  return options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
}

}  // namespace credence
