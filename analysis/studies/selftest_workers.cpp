#include "analysis/studies/selftest_workers.h"

#include <fmt/format.h>

#include "core/version.h"
#include "montecarlo/engine/shared_tasks.h"

namespace credence::internal {

void SelftestWorkers::for_each(const Items& items) {
  SharedTasks tasks;
  tasks.count = items.count;
  tasks.identity =
      fmt::format("selftest {} {} {}, part {}", version_text(), options_.seed, options_.studies, part_++);
  tasks.here = [&](std::int64_t i) {
    items.work(i);
    tell_progress();
  };
  tasks.there = [&](std::int64_t i) {
    items.work(i);
    ByteWriter writer;
    items.write(i, writer);
    return writer.take();
  };
  tasks.take = [&](std::int64_t i, std::span<const std::byte> bytes) {
    ByteReader reader(bytes, "a study of another rank");
    items.read(i, reader);
    reader.require_end();
    tell_progress();
  };
  for_each_shared_task(tasks, options_.threads, options_.stop, options_.ranks);
}

void SelftestWorkers::tell_progress() {
  const std::lock_guard lock(mutex_);
  ++done_;
  if (options_.progress) options_.progress(done_, total_);
}

bool SelftestWorkers::stopped() const {
  return is_helper(options_.ranks) ||
         (options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed));
}

}  // namespace credence::internal
