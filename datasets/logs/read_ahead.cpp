#include "datasets/logs/read_ahead.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// What a reader told, one thing after the other; emptied ones keep the memory of their rows.
class Batch {
 public:
  /// A row, or the beginning or the end of a run as a call.
  struct Entry {
    std::function<void(RowSink&)> call;
    NormalisedRow row;
  };

  Entry& next() {
    if (used_ == entries_.size()) entries_.emplace_back();
    return entries_[used_];
  }
  void add() {
    constexpr Index kOfState = 8;  // error, estimate, variance, …
    const NormalisedRow& row = entries_[used_++].row;
    numbers_ += row.left ? row.state.P.size() : row.normalised.P.size();
    numbers_ += kOfState * (row.left ? row.state.error.size() : row.normalised.error.size());
  }
  bool empty() const { return used_ == 0; }
  /// Many rows, since each batch wakes a thread, but of large states few enough for the caches.
  bool full() const { return used_ >= 512 || numbers_ >= 32'768; }

  void hand_on(RowSink& rows) {
    for (std::size_t i = 0; i < used_; ++i) {
      Entry& entry = entries_[i];
      if (entry.call) {
        std::exchange(entry.call, nullptr)(rows);
        continue;
      }
      rows.add(entry.row);
    }
    used_ = 0;
    numbers_ = 0;
  }

 private:
  std::vector<Entry> entries_;
  std::size_t used_ = 0;
  Index numbers_ = 0;
};

/// Batches on their way from one thread to another, and back when they are empty.
class BatchQueue {
 public:
  /// Takes a full batch and gives an empty one; throws Stopped where nobody takes any more. `waits`: for
  /// it somebody did.
  Batch exchange(Batch full, bool& waits) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return full_.size() < kMost || cancelled_; });
    if (cancelled_) throw Stopped{};
    waits = taker_waits_;
    full_.push_back(std::move(full));
    changed_.notify_all();
    if (empty_.empty()) return {};
    Batch empty = std::move(empty_.back());
    empty_.pop_back();
    return empty;
  }

  /// No more come; `failure`: why.
  void close(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    failure_ = std::move(failure);
    closed_ = true;
    changed_.notify_all();
  }

  /// The next one; none once it is closed and all were taken, or throws why it was closed.
  std::optional<Batch> take() {
    std::unique_lock lock(mutex_);
    taker_waits_ = true;
    changed_.wait(lock, [&] { return !full_.empty() || closed_; });
    taker_waits_ = false;
    if (full_.empty()) {
      if (failure_) std::rethrow_exception(failure_);
      return std::nullopt;
    }
    Batch batch = std::move(full_.front());
    full_.pop_front();
    changed_.notify_all();
    return batch;
  }

  void give_back(Batch empty) {
    const std::lock_guard lock(mutex_);
    empty_.push_back(std::move(empty));
  }

  void cancel() {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    changed_.notify_all();
  }

 private:
  static constexpr std::size_t kMost = 4;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Batch> full_;
  std::vector<Batch> empty_;
  std::exception_ptr failure_;
  bool closed_ = false, cancelled_ = false, taker_waits_ = false;
};

/// Collects what a reader tells.
class BatchSink final : public RowSink {
 public:
  explicit BatchSink(BatchQueue& queue) : queue_(queue) {}

  void begin_run(const std::filesystem::path& file, const RunLayout& layout,
                 const std::string& name) override {
    call([=](RowSink& rows) { rows.begin_run(file, layout, name); });
  }
  void rename_run(const std::string& name) override {
    call([=](RowSink& rows) { rows.rename_run(name); });
  }
  NormalisedRow& room() override { return batch_.next().row; }
  void add(const NormalisedRow& row) override {
    if (&row != &room()) room() = row;
    added();
  }
  bool waits() const override { return waits_; }
  void end_run(Outcome outcome, std::int64_t step) override {
    call([=](RowSink& rows) { rows.end_run(outcome, step); });
  }

  void finish() {
    if (!batch_.empty()) batch_ = queue_.exchange(std::exchange(batch_, {}), waits_);
  }

 private:
  void call(std::function<void(RowSink&)> call) {
    batch_.next().call = std::move(call);
    added();
  }
  void added() {
    batch_.add();
    if (batch_.full()) batch_ = queue_.exchange(std::exchange(batch_, {}), waits_);
  }

  BatchQueue& queue_;
  Batch batch_;
  bool waits_ = false;
};

void read_into(BatchQueue& queue, const std::atomic<bool>* stop, const std::function<void(RowSink&)>& read) {
  const StopScope scope(stop);
  BatchSink sink(queue);
  std::exception_ptr failure;
  try {
    read(sink);
  } catch (...) {
    failure = std::current_exception();
  }
  try {
    sink.finish();
  } catch (...) {
    if (!failure) failure = std::current_exception();
  }
  queue.close(failure);
}

/// Ends the reader where the scope is left early.
class CancelScope {
 public:
  explicit CancelScope(BatchQueue& queue) : queue_(queue) {}
  ~CancelScope() { queue_.cancel(); }
  CancelScope(const CancelScope&) = delete;
  CancelScope& operator=(const CancelScope&) = delete;

 private:
  BatchQueue& queue_;
};

}  // namespace

void read_ahead(RowSink& rows, const std::atomic<bool>* stop, const std::function<void(RowSink&)>& read) {
  BatchQueue queue;
  std::jthread reader;
  try {
    reader = std::jthread([&] { read_into(queue, stop, read); });
  } catch (const std::system_error&) {  // there are no more threads
    return read(rows);
  }
  const CancelScope cancel(queue);
  while (std::optional<Batch> batch = queue.take()) {
    batch->hand_on(rows);
    queue.give_back(std::move(*batch));
  }
}

}  // namespace credence::internal
