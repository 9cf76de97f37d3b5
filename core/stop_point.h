#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>

namespace credence::internal {

/// Thrown by stop_point. No std::exception: nothing is wrong, and what handles errors shall not take it.
struct Stopped {};

/// While it lives, stop_point on this thread asks this flag, or none where it is null.
class StopScope {
 public:
  explicit StopScope(const std::atomic<bool>* flag);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  const std::atomic<bool>* outer_;
};

/// While it lives, the steps of the stop points that this thread passes are told, not more often than once in
/// the interval.
class PulseScope {
 public:
  using Tell = std::function<void(std::int64_t steps)>;  ///< how many since the last time

  explicit PulseScope(Tell tell, std::chrono::milliseconds interval = std::chrono::milliseconds(500));
  ~PulseScope();
  PulseScope(const PulseScope&) = delete;
  PulseScope& operator=(const PulseScope&) = delete;

  void pass(std::int64_t steps);

 private:
  using Clock = std::chrono::steady_clock;

  Tell tell_;
  std::chrono::milliseconds interval_;
  PulseScope* outer_;
  std::int64_t steps_ = 0;     // not told yet
  std::int64_t unlooked_ = 0;  // since the last look at the clock
  Clock::time_point last_ = Clock::now();
};

/// Throws Stopped once the flag of the innermost StopScope of this thread is set: called, in the manner of
/// boost::this_thread::interruption_point, by every loop that may last longer than a user waits for an answer
/// to Ctrl-C. What was begun and not finished is dropped. `steps`: of how many runs a step follows here, as
/// the innermost PulseScope counts. Costs two loads.
void stop_point(std::int64_t steps = 1);

}  // namespace credence::internal
