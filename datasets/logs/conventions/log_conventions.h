#pragma once

#include "datasets/logs/conventions/angle_units.h"
#include "datasets/logs/conventions/innovation_repeats.h"
#include "datasets/logs/conventions/step_conventions.h"

namespace credence::internal {

/// All that logs of any states are looked at for, one behind the other.
class LogConventions {
 public:
  explicit LogConventions(LogSink& judged) : units_(judged), steps_(units_), repeats_(steps_) {}

  /// Takes what the reader finds.
  LogSink& sink() { return repeats_; }

  /// After the last step: hands on what is to be said.
  void finish() {
    repeats_.finish();
    steps_.finish();
    units_.finish();
  }

 private:
  AngleUnits units_;
  StepConventions steps_;
  InnovationRepeats repeats_;
};

}  // namespace credence::internal
