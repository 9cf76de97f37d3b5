#pragma once

#include <cstdint>

#include "analysis/evidence/verdicts/step_times.h"
#include "reports/figures/figure.h"

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

/// Of `count` steps in a row.
inline FigureData step_places(const StepTimes* times, std::size_t count, std::int64_t first = 1) {
  FigureData places;
  for (std::size_t k = 0; k < count; ++k)
    places.push_back(step_place(times, first + static_cast<std::int64_t>(k)));
  return places;
}

}  // namespace credence::internal
