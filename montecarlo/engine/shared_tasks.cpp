#include "montecarlo/engine/shared_tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "core/parallel_tasks.h"
#include "montecarlo/engine/growing_pause.h"
#include "montecarlo/engine/rank_messages.h"
#include "montecarlo/engine/task_dispenser.h"
#include "montecarlo/scenario/scenario_hash.h"

namespace credence::internal {
namespace {

using Kind = RankMessage::Kind;

bool is_set(const std::atomic<bool>* flag) {
  return flag != nullptr && flag->load(std::memory_order_relaxed);
}

/// Rank 0 in one phase: its threads and the messages of the others.
class LeadingRank {
 public:
  LeadingRank(const SharedTasks& tasks, Ranks& ranks, const std::atomic<bool>* stop)
      : tasks_(tasks),
        ranks_(ranks),
        stop_(stop),
        phase_(ranks.next_phase()),
        identity_(stable_hash(tasks.identity)),
        dispenser_(
            tasks.count, ranks.count(), [this](std::int64_t i) { return !tasks_.wanted || tasks_.wanted(i); },
            tasks.most_ahead, tasks.kept) {}

  void run(int threads) {
    {
      const std::jthread courier([this](const std::stop_token& end) { listen(end); });
      do {
        for_each_task(thread_count(threads), threads, stop_, [this](std::int64_t) {
          while (const auto task = next()) {
            tasks_.here(*task);
            const std::lock_guard lock(mutex_);
            dispenser_.done(0, *task);
          }
        });
      } while (wait_for_others());
    }
    if (failure_) std::rethrow_exception(failure_);
    for (int to = 1; to < ranks_.count(); ++to) tell(to, {.kind = Kind::over, .phase = phase_});
  }

 private:
  std::optional<std::int64_t> next() {
    const std::lock_guard lock(mutex_);
    if (failure_ || is_set(stop_)) return std::nullopt;
    const TaskRange range = dispenser_.next(0, 1);
    return range.count == 0 ? std::nullopt : std::optional(range.first);
  }

  /// Until nothing is in the hands of others; true if something of it came back undone.
  bool wait_for_others() {
    std::unique_lock lock(mutex_);
    while (!failure_ && !is_set(stop_)) {
      if (dispenser_.has_returned()) return true;
      if (dispenser_.all_done()) return false;
      changed_.wait_for(lock, GrowingPause::kLongest);
    }
    return false;
  }

  void listen(const std::stop_token& end) {
    GrowingPause pause;
    try {
      while (!end.stop_requested()) {
        if (const auto message = ranks_.receive()) {
          hear(message->from, rank_message_from_bytes(message->bytes));
          pause.shorten();
        } else {
          std::this_thread::sleep_for(pause.next());
        }
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
    }
    changed_.notify_all();
  }

  void hear(int from, const RankMessage& message) {
    if (message.kind == Kind::failed)
      throw std::runtime_error(fmt::format("rank {}: {}", from, message.text));
    if (message.phase != phase_) return;  // of one that is over
    switch (message.kind) {
      case Kind::request:
        if (message.identity != identity_) {
          throw std::runtime_error(
              fmt::format("rank {} works on another study, or is another version", from));
        }
        answer(from);
        break;
      case Kind::records:
        for (const TaskRecord& record : message.records) take(from, record);
        changed_.notify_all();
        break;
      case Kind::leaving:
        std::erase(waiting_, from);
        {
          const std::lock_guard lock(mutex_);
          dispenser_.give_back(from);
        }
        changed_.notify_all();
        for (const int waiting : std::exchange(waiting_, {})) answer(waiting);
        break;
      default: throw std::runtime_error(fmt::format("rank {} sent what only rank 0 says", from));
    }
  }

  /// Gives a rank what it asked for, or lets it wait: others may come back with theirs.
  void answer(int to) {
    TaskRange range;
    {
      const std::lock_guard lock(mutex_);
      range = dispenser_.next(to, dispenser_.guided());
    }
    if (range.count == 0) {
      waiting_.push_back(to);
    } else {
      tell(to, {.kind = Kind::range, .phase = phase_, .range = range});
    }
  }

  void take(int from, const TaskRecord& record) {
    {
      const std::lock_guard lock(mutex_);
      if (!dispenser_.holds(from, record.task)) {
        throw std::runtime_error(
            fmt::format("rank {} sent the result of a task that it was not given", from));
      }
    }
    tasks_.take(record.task, record.bytes);
    const std::lock_guard lock(mutex_);
    dispenser_.done(from, record.task);
  }

  void tell(int to, const RankMessage& message) { ranks_.send(to, to_bytes(message)); }

  const SharedTasks& tasks_;
  Ranks& ranks_;
  const std::atomic<bool>* stop_;
  std::uint64_t phase_, identity_;
  std::vector<int> waiting_;  ///< ranks, of the courier alone
  std::mutex mutex_;          ///< of what follows
  std::condition_variable changed_;
  TaskDispenser dispenser_;
  std::exception_ptr failure_;
};

/// Another rank in one phase.
class HelpingRank {
 public:
  HelpingRank(const SharedTasks& tasks, Ranks& ranks, const std::atomic<bool>* stop)
      : tasks_(tasks),
        ranks_(ranks),
        stop_(stop),
        phase_(ranks.next_phase()),
        identity_(stable_hash(tasks.identity)) {}

  void run(int threads) {
    const int count = thread_count(threads);
    {
      const std::jthread courier([this, count] { carry(static_cast<std::size_t>(count)); });
      try {
        for_each_task(count, threads, &over_, [this](std::int64_t) { work(); });
      } catch (...) {
        close();
        throw;
      }
      close();
    }
    if (failure_) std::rethrow_exception(failure_);
    if (ranks_.ended) throw RanksEnded{};
  }

 private:
  void work() {
    while (const auto task = next()) {
      TaskRecord record{.task = *task, .bytes = {}};
      try {
        record.bytes = tasks_.there(*task);
      } catch (...) {
        close();  // the other threads shall not wait for more
        throw;
      }
      const std::lock_guard lock(mutex_);
      done_.push_back(std::move(record));
      to_courier_.notify_one();
    }
  }

  std::optional<std::int64_t> next() {
    std::unique_lock lock(mutex_);
    to_threads_.wait(lock, [this] { return over_ || !ranges_.empty(); });
    if (over_) return std::nullopt;
    TaskRange& range = ranges_.front();
    const std::int64_t task = range.first++;
    --waiting_tasks_;
    if (--range.count == 0) ranges_.pop_front();
    to_courier_.notify_one();
    return task;
  }

  /// Nothing more is worked on.
  void close() {
    const std::lock_guard lock(mutex_);
    over_ = true;
    to_threads_.notify_all();
    to_courier_.notify_all();
  }

  /// Sends what is done and asks for more while there is still something to do.
  void carry(std::size_t threads) {
    GrowingPause pause;
    try {
      while (!over_) {
        std::vector<TaskRecord> records;
        bool ask = false;
        {
          std::unique_lock lock(mutex_);
          const auto hungry = [&] { return !asked_ && waiting_tasks_ < static_cast<std::int64_t>(threads); };
          to_courier_.wait_for(lock, pause.next(), [&] { return over_ || !done_.empty() || hungry(); });
          records.swap(done_);
          ask = hungry();
          asked_ = asked_ || ask;
        }
        if (!records.empty()) tell({.kind = Kind::records, .phase = phase_, .records = std::move(records)});
        if (ask) tell({.kind = Kind::request, .phase = phase_, .identity = identity_});
        if (is_set(stop_)) {
          tell({.kind = Kind::leaving, .phase = phase_});
          break;
        }
        while (const auto message = ranks_.receive()) {
          hear(rank_message_from_bytes(message->bytes));
          pause.shorten();
        }
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    close();
  }

  void hear(const RankMessage& message) {
    if (message.kind == Kind::end) ranks_.ended = true;
    if (message.kind == Kind::end || (message.kind == Kind::over && message.phase == phase_)) close();
    if (message.kind != Kind::range || message.phase != phase_) return;
    const std::lock_guard lock(mutex_);
    asked_ = false;
    waiting_tasks_ += message.range.count;
    ranges_.push_back(message.range);
    to_threads_.notify_all();
  }

  void tell(const RankMessage& message) { ranks_.send(0, to_bytes(message)); }

  const SharedTasks& tasks_;
  Ranks& ranks_;
  const std::atomic<bool>* stop_;
  std::uint64_t phase_, identity_;
  std::atomic<bool> over_ = false;  ///< also ends a task in hand (stop_point)
  std::exception_ptr failure_;      ///< of the courier, until it has ended
  std::mutex mutex_;                ///< of what follows
  std::condition_variable to_threads_, to_courier_;
  std::deque<TaskRange> ranges_;
  std::int64_t waiting_tasks_ = 0;  ///< in ranges_
  bool asked_ = false;
  std::vector<TaskRecord> done_;
};

}  // namespace

void for_each_shared_task(const SharedTasks& tasks, int threads, const std::atomic<bool>* stop,
                          Ranks* ranks) {
  if (ranks == nullptr || ranks->count() == 1) {
    for_each_task(tasks.count, threads, stop, [&](std::int64_t i) {
      if (!tasks.wanted || tasks.wanted(i)) tasks.here(i);
    });
    return;
  }
  threads = std::max(1, threads);
  if (ranks->rank() == 0) {
    LeadingRank(tasks, *ranks, stop).run(threads);
  } else {
    HelpingRank(tasks, *ranks, stop).run(threads);
  }
}

void report_failure(Ranks& ranks, const std::string& why) {
  ranks.send(0, to_bytes(RankMessage{.kind = Kind::failed, .text = why}));
}

void finish_ranks(Ranks& ranks) {
  const auto next_kind = [&] {
    while (true) {
      if (const auto message = ranks.receive()) return rank_message_from_bytes(message->bytes).kind;
      std::this_thread::sleep_for(GrowingPause::kLongest);
    }
  };
  if (ranks.rank() == 0) {
    for (int to = 1; to < ranks.count(); ++to) ranks.send(to, to_bytes(RankMessage{.kind = Kind::end}));
    for (int left = ranks.count() - 1; left > 0;) left -= next_kind() == Kind::bye ? 1 : 0;
  } else {
    while (!ranks.ended) ranks.ended = next_kind() == Kind::end;
    ranks.send(0, to_bytes(RankMessage{.kind = Kind::bye}));
  }
}

}  // namespace credence::internal
