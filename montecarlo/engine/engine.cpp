#include "montecarlo/engine/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>

#include "core/stop_point.h"
#include "core/version.h"
#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/engine/shared_tasks.h"

namespace credence::internal {
namespace {

struct Chunk {
  std::size_t task = 0;
  std::size_t index = 0;  ///< within its task
  std::int64_t first_run = 0;
  std::int64_t runs = 0;
};

/// All chunks of all tasks under one numbering, task by task, without a list of them.
class ChunkNumbering {
 public:
  explicit ChunkNumbering(std::span<const StudyTask> tasks) : tasks_(tasks) {
    for (const StudyTask& task : tasks) {
      begin_.push_back(count_);
      count_ += static_cast<std::size_t>((task.runs + kChunkRuns - 1) / kChunkRuns);
    }
  }

  std::size_t count() const { return count_; }
  std::size_t number(std::size_t task, std::size_t index) const { return begin_[task] + index; }

  Chunk operator[](std::size_t number) const {
    const auto next = std::upper_bound(begin_.begin(), begin_.end(), number);
    Chunk chunk;
    chunk.task = static_cast<std::size_t>(next - begin_.begin()) - 1;
    chunk.index = number - begin_[chunk.task];
    chunk.first_run = static_cast<std::int64_t>(chunk.index) * kChunkRuns;
    chunk.runs = std::min(kChunkRuns, tasks_[chunk.task].runs - chunk.first_run);
    return chunk;
  }

 private:
  std::span<const StudyTask> tasks_;
  std::vector<std::size_t> begin_;
  std::size_t count_ = 0;
};

/// The chunks of one task: those ahead of the first gap are merged as soon as they are there.
class PartialStudy {
 public:
  /// True if this chunk let the study end before its last run.
  bool put(std::size_t index, StudyStatistics statistics, const StudyWatch& enough) {
    if (ended_) return false;
    waiting_.emplace(index, std::move(statistics));
    for (auto first = waiting_.begin(); !ended_ && first != waiting_.end() && first->first == next_;
         first = waiting_.erase(first), ++next_) {
      if (next_ == 0) {
        merged_ = first->second;
      } else {
        merged_.merge(first->second);
      }
      ended_ = enough && enough(first->second, merged_);
    }
    return ended_;
  }

  bool ended() const { return ended_; }
  std::int64_t runs() const { return merged_.runs; }

  StudyResult take(std::int64_t runs) {
    StudyResult result{.statistics = std::move(merged_)};
    result.complete = ended_ || result.statistics.runs == runs;
    return result;
  }

 private:
  bool ended_ = false;
  std::map<std::size_t, StudyStatistics> waiting_;  ///< those behind a gap
  std::size_t next_ = 0;
  StudyStatistics merged_;
};

/// Whether a chunk is this process's.
bool in_shard(std::size_t number, const EngineOptions& options) {
  return number % static_cast<std::size_t>(options.shards) == static_cast<std::size_t>(options.shard - 1);
}

/// Whether these statistics may be those of a chunk: they tell how many runs they are of, and which of these
/// went wrong. Runs that all went well are told by nothing.
bool may_be_of(const ChunkKey& key, std::int64_t steps, const StudyStatistics& statistics) {
  const auto is_here = [&](const auto& of_run) {
    return of_run.run >= key.first_run && of_run.run < key.first_run + key.runs;
  };
  return statistics.runs == key.runs && (steps == 0 || std::ssize(statistics.steps) == steps) &&
         std::ranges::all_of(statistics.failures, is_here) &&
         std::ranges::all_of(statistics.not_converged, is_here);
}

/// What the workers share, under one lock; nobody waits under it while a chunk is written to the disk.
class ChunkCollector {
 public:
  ChunkCollector(std::span<const StudyTask> tasks, const EngineOptions& options)
      : tasks_(tasks), options_(options), studies_(tasks.size()) {
    for (const StudyTask& task : tasks) progress_.runs_total += task.runs;
    progress_.runs_total /= options.shards;  // to a chunk
    begun_.resize(tasks.size());
    timed_out_.resize(tasks.size());
    shard_runs_done_.resize(tasks.size());
  }

  /// Takes what the store has; marks in `done` the numbers of the chunks found.
  void load(const ChunkNumbering& chunks, std::vector<bool>& done) {
    if (options_.store == nullptr) return;
    for (std::size_t t = 0; t < tasks_.size(); ++t) {
      for (const ChunkKey& key : options_.store->chunks(tasks_[t].id)) {
        const std::size_t number = chunks.number(t, static_cast<std::size_t>(key.first_run / kChunkRuns));
        // A study may have been run with fewer or more runs: its last chunk is then another one.
        if (key.first_run >= tasks_[t].runs || key_of(chunks[number]) != key) continue;
        if (studies_[t].ended()) break;
        StudyStatistics statistics = statistics_from_bytes(options_.store->get_chunk(key).value());
        if (!may_be_of(key, tasks_[t].steps, statistics)) {
          options_.store->refuse(key, "they are those of another chunk");
        }
        add(t, chunks[number].index, std::move(statistics));
        if (tasks_[t].found) {
          const auto bytes = options_.store->get_companion(key);
          if (bytes && !tasks_[t].found(key.first_run, key.runs, *bytes)) {
            options_.store->refuse(key, "the evidence beside them is that of another chunk");
          }
        }
        if (in_shard(number, options_)) {
          progress_.runs_stored += key.runs;
          shard_runs_done_[t] += key.runs;
        }
        done[number] = true;
      }
    }
  }

  /// Whether a chunk of this task is still wanted.
  bool wants(std::size_t task) {
    const std::lock_guard lock(mutex_);
    if (studies_[task].ended() || timed_out_[task]) return false;
    const auto now = Clock::now();
    if (!begun_[task]) begun_[task] = now;
    const double limit = tasks_[task].max_seconds;
    timed_out_[task] = limit > 0.0 && std::chrono::duration<double>(now - *begun_[task]).count() > limit;
    return !timed_out_[task];
  }

  void put(const Chunk& chunk, StudyStatistics statistics) {
    std::vector<std::byte> bytes;
    if (options_.store != nullptr) {
      bytes = to_bytes(statistics);
      put_companion(chunk);
    }
    put(chunk, bytes, std::move(statistics));
  }

  /// A part of a chunk was done, or (negative) is no longer in hand.
  void add_in_hand(double runs) {
    const std::lock_guard lock(mutex_);
    progress_.runs_in_hand = std::max(0.0, progress_.runs_in_hand + runs);
    if (runs > 0.0 && options_.progress) options_.progress(progress_);
  }

  /// The same of a chunk that is there as bytes, too. They are packed before the lock is asked for.
  void put(const Chunk& chunk, std::span<const std::byte> bytes, StudyStatistics statistics) {
    put(chunk, bytes, options_.store == nullptr ? std::vector<std::byte>() : packed(bytes),
        std::move(statistics));
  }

  /// And as a frame.
  void put(const Chunk& chunk, std::span<const std::byte> bytes, std::span<const std::byte> frame,
           StudyStatistics statistics) {
    if (options_.store != nullptr) {
      const std::lock_guard lock(store_mutex_);
      options_.store->put_chunk(key_of(chunk), bytes, frame);
    }
    const std::lock_guard lock(mutex_);
    add(chunk.task, chunk.index, std::move(statistics));
    shard_runs_done_[chunk.task] += chunk.runs;
    progress_.runs_done += chunk.runs;
    if (options_.progress) options_.progress(progress_);
  }

  std::vector<StudyResult> take(const ChunkNumbering& chunks) {
    std::vector<StudyResult> results;
    for (std::size_t t = 0; t < tasks_.size(); ++t) {
      results.push_back(studies_[t].take(tasks_[t].runs));
      results.back().timed_out = timed_out_[t] && !results.back().complete;
      results.back().complete = results.back().complete || timed_out_[t];
      results.back().shard_runs = shard_runs(chunks, t);
      results.back().shard_runs_done = shard_runs_done_[t];
    }
    return results;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::int64_t shard_runs(const ChunkNumbering& chunks, std::size_t task) const {
    if (options_.shards == 1) return tasks_[task].runs;
    std::int64_t runs = 0;
    const auto count = static_cast<std::size_t>((tasks_[task].runs + kChunkRuns - 1) / kChunkRuns);
    for (std::size_t index = 0; index < count; ++index) {
      const std::size_t number = chunks.number(task, index);
      if (in_shard(number, options_)) runs += chunks[number].runs;
    }
    return runs;
  }

  void add(std::size_t task, std::size_t index, StudyStatistics statistics) {
    if (studies_[task].put(index, std::move(statistics), tasks_[task].enough)) {
      progress_.runs_total -= tasks_[task].runs - studies_[task].runs();
    }
  }

  void put_companion(const Chunk& chunk) {
    const StudyTask& task = tasks_[chunk.task];
    if (!task.companion) return;
    const std::vector<std::byte> bytes = task.companion(chunk.first_run, chunk.runs);
    if (bytes.empty()) return;
    const std::vector<std::byte> frame = packed(bytes);
    const std::lock_guard lock(store_mutex_);
    options_.store->put_companion(key_of(chunk), bytes, frame);
  }

  ChunkKey key_of(const Chunk& chunk) const { return {tasks_[chunk.task].id, chunk.first_run, chunk.runs}; }

  std::span<const StudyTask> tasks_;
  const EngineOptions& options_;
  std::mutex store_mutex_;  ///< of the store; never together with the other
  std::mutex mutex_;        ///< of all that follows
  std::vector<PartialStudy> studies_;
  std::vector<std::optional<Clock::time_point>> begun_;
  std::vector<bool> timed_out_;
  std::vector<std::int64_t> shard_runs_done_;
  StudyProgress progress_;
};

/// Tells of a chunk in hand while it is computed.
class ChunkInHand {
 public:
  ChunkInHand(ChunkCollector& collector, std::int64_t steps)
      : collector_(collector), pulse_([this, steps](std::int64_t done) {
          if (steps <= 0) return;
          const double runs = static_cast<double>(done) / static_cast<double>(steps);
          runs_ += runs;
          collector_.add_in_hand(runs);
        }) {}
  ~ChunkInHand() {
    if (runs_ > 0.0) collector_.add_in_hand(-runs_);
  }
  ChunkInHand(const ChunkInHand&) = delete;
  ChunkInHand& operator=(const ChunkInHand&) = delete;

 private:
  ChunkCollector& collector_;
  double runs_ = 0.0;
  PulseScope pulse_;
};

/// What all ranks must agree on: the configurations, their runs, and the program.
std::string identity_of(std::span<const StudyTask> tasks) {
  std::string text = version_text();
  for (const StudyTask& task : tasks) text += fmt::format("\n{} {}", task.id, task.runs);
  return text;
}

/// Whether a study may end before its last run: chunks far ahead may then be for nothing.
bool may_end_early(const StudyTask& task) { return task.enough || task.max_seconds > 0.0; }

}  // namespace

std::vector<StudyResult> run_studies(std::span<const StudyTask> tasks, const EngineOptions& options) {
  const ChunkNumbering chunks(tasks);
  std::vector<bool> done(chunks.count());
  ChunkCollector collector(tasks, options);
  collector.load(chunks, done);

  const auto chunk_of = [&](std::int64_t i) { return chunks[static_cast<std::size_t>(i)]; };
  const auto run = [&](const Chunk& chunk) {
    const StudyTask& task = tasks[chunk.task];
    const ChunkInHand in_hand(collector, task.steps);
    return task.play ? task.play(chunk.first_run, chunk.runs)
                     : task.experiment->run_chunk(chunk.first_run, chunk.runs);
  };
  SharedTasks shared;
  shared.count = static_cast<std::int64_t>(chunks.count());
  shared.identity = identity_of(tasks);
  shared.wanted = [&](std::int64_t i) {
    const auto number = static_cast<std::size_t>(i);
    return !done[number] && in_shard(number, options) && collector.wants(chunk_of(i).task);
  };
  shared.here = [&](std::int64_t i) { collector.put(chunk_of(i), run(chunk_of(i))); };
  shared.there = [&](std::int64_t i) { return packed(to_bytes(run(chunk_of(i)))); };
  shared.take = [&](std::int64_t i, std::span<const std::byte> frame) {
    const std::vector<std::byte> bytes = unpacked(frame);
    collector.put(chunk_of(i), bytes, frame, statistics_from_bytes(bytes));
  };
  if (std::ranges::any_of(tasks, may_end_early)) {
    shared.most_ahead = 1;
  } else if (tasks.size() == 1) {
    shared.kept = (tasks.front().kept_runs + kChunkRuns - 1) / kChunkRuns;
  }
  for_each_shared_task(shared, options.threads, options.stop, options.ranks);
  if (options.store != nullptr) options.store->commit();
  return collector.take(chunks);
}

}  // namespace credence::internal
