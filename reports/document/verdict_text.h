#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"

namespace credence::internal {

/// "optimistic in heading from step 180 on; times 1.3 on P the mean NEES would be right", and what that
/// leaves (left_by_scale), as in "times 1.3 on P would make the mean NEES right and leave heading
/// optimistic". blocks: those of the state, where known.
std::string word_clause(const Word& word, const ConsistencyVerdict& nees,
                        std::span<const BlockVerdict> blocks = {});

/// "planar_loop: optimistic in heading from step 180 on; times 1.3 on P the mean NEES would be right."
std::string word_sentence(const std::string& name, const Word& word, const ConsistencyVerdict& nees,
                          std::span<const BlockVerdict> blocks = {});

/// The step whose test decided that a verdict is inconsistent; null where the mean did, or the sensors.
const StepTest* deciding_step(const ConsistencyVerdict& verdict);

/// What the value of a verdict would have to lie within: the bounds of its mean, or where a step decided
/// those of that step and what it has.
std::string trusted_text(const ConsistencyVerdict& v);

/// "map, pairwise" and the like.
std::string filter_text(const FilterSettings& filter);

/// "27.8 of 22.1": the mean, and what is expected.
std::string against_expected(const ConsistencyVerdict& v);

/// A verdict in words: its number, bounds, p-value and how many tests were made.
std::string verdict_sentence(const char* what, const ConsistencyVerdict& verdict);

/// "In 12 steps of 3 of 100 runs (runs 5, 7, 9) the filter's iteration stopped before it had converged; …",
/// of `all` runs. Empty where there are none.
std::string not_converged_sentence(std::span<const RunNotConverged> runs, std::int64_t all);

/// A verdict as a cell.
TableCell verdict_cell(Verdict verdict);

}  // namespace credence::internal
