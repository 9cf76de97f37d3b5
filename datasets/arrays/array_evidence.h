#pragma once

#include <atomic>

#include "analysis/calibration/calibration_sums.h"
#include "analysis/evidence/sums/evidence.h"
#include "datasets/arrays/array_runs.h"
#include "datasets/judged_states.h"

namespace credence::internal {

/// Adds up all rows, with the sums that a log of the same numbers gives, bit for bit.
///
/// Runs are added kChunkRuns at a time, in their order, so the bits do not depend on `threads` (0: one for
/// each processor). What is rejected is named "run R:STEP", runs from 0, steps from 1. Nothing is copied but
/// the row at hand. Throws std::invalid_argument as ArrayReader does, for the first bad run; and for no rows.
/// Returns less than all runs once `stop` is set. Of a state that is calibrated the runs go behind
/// `calibration` as well, and what is judged into `judged`, unless these are null.
Evidence add_arrays(const ArrayRuns& arrays, int threads = 0, const std::atomic<bool>* stop = nullptr,
                    CalibrationUnits* calibration = nullptr, JudgedStates* judged = nullptr);

}  // namespace credence::internal
