#include "core/stop_point.h"

#include <utility>

namespace credence::internal {
namespace {

thread_local const std::atomic<bool>* flag_of_this_thread = nullptr;
thread_local PulseScope* pulse_of_this_thread = nullptr;

}  // namespace

StopScope::StopScope(const std::atomic<bool>* flag) : outer_(flag_of_this_thread) {
  flag_of_this_thread = flag;
}

StopScope::~StopScope() { flag_of_this_thread = outer_; }

PulseScope::PulseScope(Tell tell, std::chrono::milliseconds interval)
    : tell_(std::move(tell)), interval_(interval), outer_(pulse_of_this_thread) {
  pulse_of_this_thread = this;
}

PulseScope::~PulseScope() { pulse_of_this_thread = outer_; }

void PulseScope::pass(std::int64_t steps) {
  constexpr std::int64_t kBetweenLooks = 64;  // steps between looks at the clock
  steps_ += steps;
  if ((unlooked_ += steps) < kBetweenLooks) return;
  unlooked_ = 0;
  const Clock::time_point now = Clock::now();
  if (now - last_ < interval_) return;
  last_ = now;
  tell_(std::exchange(steps_, 0));
}

void stop_point(std::int64_t steps) {
  if (pulse_of_this_thread != nullptr) pulse_of_this_thread->pass(steps);
  if (flag_of_this_thread != nullptr && flag_of_this_thread->load(std::memory_order_relaxed)) throw Stopped{};
}

}  // namespace credence::internal
