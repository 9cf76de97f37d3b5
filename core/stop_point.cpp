#include "core/stop_point.h"

namespace credence {
namespace {

thread_local const std::atomic<bool>* flag_of_this_thread = nullptr;

}  // namespace

StopScope::StopScope(const std::atomic<bool>* flag) : outer_(flag_of_this_thread) {
  flag_of_this_thread = flag;
}

StopScope::~StopScope() { flag_of_this_thread = outer_; }

void stop_point() {
  if (flag_of_this_thread != nullptr && flag_of_this_thread->load(std::memory_order_relaxed)) throw Stopped{};
}

}  // namespace credence
