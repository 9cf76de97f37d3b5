#pragma once

#include <atomic>

namespace credence {

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

/// Throws Stopped once the flag of the innermost StopScope of this thread is set: called, in the manner of
/// boost::this_thread::interruption_point, by every loop that may last longer than a user waits for an answer
/// to Ctrl-C. What was begun and not finished is dropped. Costs a load.
void stop_point();

}  // namespace credence
