#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/record/run_layout.h"
#include "montecarlo/engine/study_statistics.h"

/// @file
/// Runs of a filter that lie in memory as arrays: what `credence check` reads from files, without the files.

namespace credence::internal {

/// Rows of doubles, one for each step; within a row they lie one after the other. A stride of 0 says the same
/// at every step.
struct ArrayRows {
  const double* data = nullptr;  ///< null: there are none
  std::ptrdiff_t stride = 0;     ///< from row to row, in doubles

  const double* at(std::int64_t row) const { return data + row * stride; }
};

/// The innovations of one sensor, of dimension m.
struct InnovationRows {
  ArrayRows nu;   ///< m; NaN: the sensor, or this component of it, is silent
  ArrayRows S;    ///< m×m; not read where nu is NaN
  ArrayRows R{};  ///< m×m: of the measurement, as the filter assumes it; none: not known
};

/// One run. Row k is step k + 1.
struct ArrayRun {
  std::int64_t steps = 0;
  ArrayRows error{};                          ///< n: x̂ ⊟ x; NaN: a state without estimate or truth
  ArrayRows P{};                              ///< n×n; not read where the error is NaN
  ArrayRows estimate{};                       ///< n: x̂, where the error is a difference; none: not known
  std::vector<InnovationRows> innovations{};  ///< one for each sensor of the layout
  /// Where a run ended that failed; its rows are those before.
  std::optional<RunFailure> failure{};
};

/// How messages count: P[step], P[run, step] or P[run][step].
enum class ArrayIndexing { single, stacked, listed };

/// All runs of a filter, and what their rows mean.
struct ArrayRuns {
  RunLayout layout;
  std::vector<ArrayRun> runs;
  ArrayIndexing indexing = ArrayIndexing::stacked;
  std::int64_t first_run = 0;  ///< the number of runs[0], for messages
};

}  // namespace credence::internal
