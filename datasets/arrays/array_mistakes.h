#pragma once

#include <string>

#include "datasets/arrays/array_runs.h"
#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// What looks like a mistake of who made the arrays.
struct ArrayMistakes {
  Said said;
  std::string swapped_axes;  ///< (steps, runs, n) for (runs, steps, n); empty: not
};

/// What a log of the same numbers is told of mistakes of units and conventions (StepConventions, AngleUnits,
/// InnovationRepeats, SwappedAxes); of some thousand rows, evenly spread, of innovations the first, or of
/// all where there are estimates. Throws as ArrayReader does.
ArrayMistakes array_mistakes(const ArrayRuns& arrays);

}  // namespace credence::internal
