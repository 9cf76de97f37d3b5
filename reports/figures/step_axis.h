#pragma once

#include <cstdint>

#include "analysis/evidence/verdicts/step_times.h"

/// @file
/// The abscissa of what is shown by step: time where the runs tell it, else the number of the step.

namespace credence::internal {

/// times: null where not known.
inline const char* step_label(const StepTimes* times) {
  return times == nullptr ? "step" : times->as_told() ? "time (s)" : "time since the start (s)";
}

inline double step_place(const StepTimes* times, std::int64_t step) {
  return times == nullptr ? static_cast<double>(step) : times->at(step);
}

}  // namespace credence::internal
