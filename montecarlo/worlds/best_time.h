#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace credence::internal {

/// The shortest of several times that `work()` takes, s.
template <class Work>
double best_time(int repeats, const Work& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

}  // namespace credence::internal
