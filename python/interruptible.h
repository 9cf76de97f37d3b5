#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace credence::internal {

/// How far some work is: told by any thread, and asked by the one that waits for it.
class WorkDone {
 public:
  void tell(double done, double total) {
    const std::lock_guard lock(mutex_);
    now_ = {done, total};
  }
  /// What was told since it was last asked.
  std::optional<std::pair<double, double>> news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(now_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::optional<std::pair<double, double>> now_;
};

/// What a caller in Python wants to be told: nothing, or a function of (done, total).
using PythonProgress = std::optional<pybind11::function>;

/// work(stop, done) on a thread of its own, without the GIL. Ctrl-C, or an exception of `progress`, sets
/// `stop`, and is raised once the work has ended. `progress` is called by the caller's thread.
template <class Work>
auto interruptible(const Work& work, const PythonProgress& progress = std::nullopt) {
  constexpr std::chrono::milliseconds kBetweenLooks{50};
  std::atomic<bool> stop = false;
  const auto done = std::make_shared<WorkDone>();  // a result may tell it long after this call
  std::optional<pybind11::error_already_set> raised;
  const auto look = [&] {
    try {
      if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
      if (const auto news = done->news(); news && progress) (*progress)(news->first, news->second);
    } catch (pybind11::error_already_set& error) {
      raised.emplace(error);
    }
  };
  auto result = std::async(std::launch::async, [&] { return work(stop, done); });
  {
    const pybind11::gil_scoped_release released;
    while (!raised && result.wait_for(kBetweenLooks) != std::future_status::ready) {
      const pybind11::gil_scoped_acquire held;
      look();
    }
    stop = raised.has_value();
    result.wait();
  }
  if (!raised) look();
  if (raised) throw *raised;
  return result.get();
}

}  // namespace credence::internal
