#pragma once

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

#include "core/stop_point.h"
#include "montecarlo/engine/engine.h"

namespace credence::internal {

/// Shows on stderr how far a study is: a bar on a terminal, else a line every few seconds; nothing for what
/// takes less than two seconds.
class ProgressDisplay {
 public:
  /// `unit`: of what StudyProgress counts.
  ProgressDisplay(const std::string& what, bool quiet, std::string unit = "runs");
  ~ProgressDisplay();  ///< clears the bar
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  /// Of an unknown total (0) there is no bar and no time left.
  void show(const StudyProgress& progress);

 private:
  /// The longest of these that fits, or on no terminal the first.
  void put(std::initializer_list<std::string> texts);

  using Clock = std::chrono::steady_clock;

  std::string what_, unit_;
  bool quiet_, terminal_;
  bool shown_ = false;
  Clock::time_point begin_ = Clock::now(), last_ = begin_;
};

/// Shows how many stop points this thread has passed while it lives, of work whose length is not known.
class StepDisplay {
 public:
  StepDisplay(const std::string& what, bool quiet, std::string unit)
      : display_(what, quiet, std::move(unit)), pulse_([this](std::int64_t steps) {
          progress_.runs_done += steps;
          display_.show(progress_);
        }) {}

 private:
  ProgressDisplay display_;
  StudyProgress progress_;
  PulseScope pulse_;
};

}  // namespace credence::internal
