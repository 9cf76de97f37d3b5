#pragma once

#include <string>
#include <vector>

#include "datasets/arrays/array_runs.h"

namespace credence::internal {

/// What a log of the same numbers is told of mistakes of units and conventions (StepConventions, AngleUnits,
/// InnovationRepeats), in sentences; of some thousand rows, evenly spread, of innovations the first, or of
/// all where there are estimates. Throws as ArrayReader does.
std::vector<std::string> array_mistakes(const ArrayRuns& arrays);

}  // namespace credence::internal
