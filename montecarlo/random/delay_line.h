#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "core/types.h"

namespace credence::internal {

/// What comes out as many steps later as it is long.
template <class T>
class DelayLine {
 public:
  explicit DelayLine(Index steps = 0) : steps_(steps) {}

  void clear() { line_.clear(); }

  /// What went in `steps` ago; nothing before the first has come through.
  std::optional<T> pass(T now) {
    line_.push_back(std::move(now));
    if (std::ssize(line_) <= steps_) return std::nullopt;
    T out = std::move(line_.front());
    line_.pop_front();
    return out;
  }

 private:
  Index steps_;
  std::deque<T> line_;
};

}  // namespace credence::internal
