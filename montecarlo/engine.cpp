#include "montecarlo/engine.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>

#include "montecarlo/result_store.h"

namespace credence {
namespace {

struct Chunk {
  std::size_t task = 0;
  std::size_t index = 0;  ///< within its task
  std::int64_t first_run = 0;
  std::int64_t runs = 0;
};

std::vector<Chunk> chunks_of(std::span<const StudyTask> tasks) {
  std::vector<Chunk> chunks;
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    std::size_t index = 0;
    for (std::int64_t first = 0; first < tasks[t].runs; first += kChunkRuns) {
      chunks.push_back({t, index++, first, std::min(kChunkRuns, tasks[t].runs - first)});
    }
  }
  return chunks;
}

/// The chunks of one task: those ahead of the first gap are merged as soon as they are there.
class PartialStudy {
 public:
  void put(std::size_t index, StudyStatistics statistics) {
    if (waiting_.size() <= index) waiting_.resize(index + 1);
    waiting_[index] = std::move(statistics);
    while (next_ < waiting_.size() && waiting_[next_]) {
      if (next_ == 0) {
        merged_ = std::move(*waiting_[0]);
      } else {
        merged_.merge(*waiting_[next_]);
      }
      waiting_[next_++].reset();
    }
  }

  StudyResult take(std::int64_t runs) {
    StudyResult result{std::move(merged_), false};
    result.complete = result.statistics.runs == runs;
    return result;
  }

 private:
  std::vector<std::optional<StudyStatistics>> waiting_;
  std::size_t next_ = 0;
  StudyStatistics merged_;
};

/// What the workers share; every access is under one lock, which a worker takes once a chunk.
class Collector {
 public:
  Collector(std::span<const StudyTask> tasks, const EngineOptions& options)
      : tasks_(tasks), options_(options), studies_(tasks.size()) {
    for (const StudyTask& task : tasks) progress_.runs_total += task.runs;
  }

  /// Takes a chunk from the store; false if it is not there.
  bool load(const Chunk& chunk) {
    if (options_.store == nullptr) return false;
    const auto bytes = options_.store->get_chunk(key_of(chunk));
    if (!bytes) return false;
    studies_[chunk.task].put(chunk.index, statistics_from_bytes(*bytes));
    progress_.runs_stored += chunk.runs;
    return true;
  }

  void put(const Chunk& chunk, StudyStatistics statistics) {
    const std::lock_guard lock(mutex_);
    if (options_.store != nullptr) options_.store->put_chunk(key_of(chunk), to_bytes(statistics));
    studies_[chunk.task].put(chunk.index, std::move(statistics));
    progress_.runs_done += chunk.runs;
    if (options_.progress) options_.progress(progress_);
  }

  std::vector<StudyResult> take() {
    std::vector<StudyResult> results;
    for (std::size_t t = 0; t < tasks_.size(); ++t) results.push_back(studies_[t].take(tasks_[t].runs));
    return results;
  }

 private:
  ChunkKey key_of(const Chunk& chunk) const { return {tasks_[chunk.task].id, chunk.first_run, chunk.runs}; }

  std::span<const StudyTask> tasks_;
  const EngineOptions& options_;
  std::mutex mutex_;
  std::vector<PartialStudy> studies_;
  StudyProgress progress_;
};

}  // namespace

std::vector<StudyResult> run_studies(std::span<const StudyTask> tasks, const EngineOptions& options) {
  Collector collector(tasks, options);
  std::vector<Chunk> open;
  std::int64_t number = 0;
  for (const Chunk& chunk : chunks_of(tasks)) {
    const bool ours = number++ % options.shards == options.shard - 1;
    if (!collector.load(chunk) && ours) open.push_back(chunk);
  }

  const int threads = options.threads > 0
                          ? options.threads
                          : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  // Allows the arena more workers than processors when the user asks for them.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, open.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (options.stop != nullptr && options.stop->load(std::memory_order_relaxed)) return;
            const Chunk& chunk = open[i];
            collector.put(chunk, tasks[chunk.task].experiment->run_chunk(chunk.first_run, chunk.runs));
          }
        },
        tbb::simple_partitioner());
  });
  if (options.store != nullptr) options.store->commit();
  return collector.take();
}

}  // namespace credence
