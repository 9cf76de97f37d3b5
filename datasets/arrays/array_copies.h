#pragma once

#include "datasets/arrays/array_runs.h"
#include "datasets/logs/rounded_copies.h"

namespace credence::internal {

/// Runs whose errors, or innovations of the first sensor, are nearly those of another one (RoundedCopies), of
/// the first 4096.
CopiedRuns array_copies(const ArrayRuns& arrays);

}  // namespace credence::internal
