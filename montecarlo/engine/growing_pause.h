#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

namespace credence::internal {

/// Pauses between looks at something that takes its time: short after it has moved, since more may follow,
/// then each twice the one before. Every look takes a core from those that work.
class GrowingPause {
 public:
  static constexpr std::chrono::microseconds kLongest{5000};

  void shorten() { pause_ = kShortest; }
  std::chrono::microseconds next() { return std::exchange(pause_, std::min(2 * pause_, kLongest)); }

 private:
  static constexpr std::chrono::microseconds kShortest{20};
  std::chrono::microseconds pause_ = kShortest;
};

}  // namespace credence::internal
