#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>

namespace credence::internal {

/// work(stop) on a thread of its own, without the GIL. Ctrl-C sets `stop`, and is raised once the work has
/// ended.
template <class Work>
auto interruptible(const Work& work) {
  constexpr std::chrono::milliseconds kBetweenLooks{50};
  std::atomic<bool> stop = false;
  auto result = std::async(std::launch::async, [&] { return work(stop); });
  bool interrupted = false;
  {
    const pybind11::gil_scoped_release released;
    while (!interrupted && result.wait_for(kBetweenLooks) != std::future_status::ready) {
      const pybind11::gil_scoped_acquire held;
      interrupted = PyErr_CheckSignals() != 0;
    }
    stop = interrupted;
    result.wait();
  }
  if (interrupted) throw pybind11::error_already_set();
  return result.get();
}

}  // namespace credence::internal
