#include "datasets/logs/read_ahead.h"

#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "core/nan.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// What a reader told, one thing after the other; emptied ones keep the memory of their steps.
class Batch {
 public:
  /// A step, or anything else as a call.
  struct Entry {
    std::function<void(LogSink&)> call;
    Step step;
    double travelled_m = kNaN, time_s = kNaN;
  };

  Entry& next() {
    if (used_ == entries_.size()) entries_.emplace_back();
    return entries_[used_++];
  }
  void add_numbers(Index count) { numbers_ += count; }
  bool empty() const { return used_ == 0; }
  bool full() const { return used_ >= 128 || numbers_ >= 32'768; }

  void hand_on(LogSink& sink) {
    for (std::size_t i = 0; i < used_; ++i) {
      Entry& entry = entries_[i];
      if (entry.call) {
        std::exchange(entry.call, nullptr)(sink);
        continue;
      }
      if (!std::isnan(entry.travelled_m)) sink.travelled(entry.travelled_m);
      if (!std::isnan(entry.time_s)) sink.at(entry.time_s);
      sink.add(entry.step);
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
  /// Takes a full batch and gives an empty one; throws Stopped where nobody takes any more.
  Batch exchange(Batch full) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return full_.size() < kMost || cancelled_; });
    if (cancelled_) throw Stopped{};
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
    changed_.wait(lock, [&] { return !full_.empty() || closed_; });
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
  bool closed_ = false, cancelled_ = false;
};

/// Collects what a reader tells.
class BatchSink final : public LogSink {
 public:
  explicit BatchSink(BatchQueue& queue) : queue_(queue) {}

  void run_number(double number) override { say(&LogSink::run_number, number); }
  void begin_run(const RunLayout& layout) override {
    call([layout](LogSink& sink) { sink.begin_run(layout); });
  }
  void add(const Step& step) override {
    Batch::Entry& entry = batch_.next();
    entry.step = step;
    entry.travelled_m = std::exchange(travelled_m_, kNaN);
    entry.time_s = std::exchange(time_s_, kNaN);
    batch_.add_numbers(step.P.size());
    send_if_full();
  }
  void travelled(double distance_m) override { travelled_m_ = distance_m; }
  void at(double time_s) override { time_s_ = time_s; }
  void end_run(Outcome outcome, std::int64_t step) override {
    call([=](LogSink& sink) { sink.end_run(outcome, step); });
  }
  void remark(std::string sentence) override { say(&LogSink::remark, std::move(sentence)); }
  void hint(std::string sentence) override { say(&LogSink::hint, std::move(sentence)); }
  void mistake(std::string sentence) override { say(&LogSink::mistake, std::move(sentence)); }
  void unexplained() override { call(&LogSink::unexplained); }
  void charts(ChartFindings findings) override { say(&LogSink::charts, std::move(findings)); }
  void time_offset(TimeOffset offset) override { say(&LogSink::time_offset, std::move(offset)); }
  void truth_fit(TruthFit fit) override { say(&LogSink::truth_fit, fit); }
  void unmatched(std::int64_t rows) override { say(&LogSink::unmatched, rows); }
  void advance(std::int64_t bytes) override { say(&LogSink::advance, bytes); }

  void finish() {
    if (!batch_.empty()) batch_ = queue_.exchange(std::exchange(batch_, {}));
  }

 private:
  void call(std::function<void(LogSink&)> call) {
    batch_.next().call = std::move(call);
    send_if_full();
  }
  template <class Value>
  void say(void (LogSink::*tell)(Value), Value value) {
    call([tell, value = std::move(value)](LogSink& sink) { (sink.*tell)(value); });
  }
  void send_if_full() {
    if (batch_.full()) batch_ = queue_.exchange(std::exchange(batch_, {}));
  }

  BatchQueue& queue_;
  Batch batch_;
  double travelled_m_ = kNaN, time_s_ = kNaN;  // of the next step
};

void read_into(BatchQueue& queue, const std::atomic<bool>* stop, const std::function<void(LogSink&)>& read) {
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

void read_ahead(LogSink& sink, const std::atomic<bool>* stop, const std::function<void(LogSink&)>& read) {
  BatchQueue queue;
  std::jthread reader;
  try {
    reader = std::jthread([&] { read_into(queue, stop, read); });
  } catch (const std::system_error&) {  // there are no more threads
    return read(sink);
  }
  const CancelScope cancel(queue);
  while (std::optional<Batch> batch = queue.take()) {
    batch->hand_on(sink);
    queue.give_back(std::move(*batch));
  }
}

}  // namespace credence::internal
