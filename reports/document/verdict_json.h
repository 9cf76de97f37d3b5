#pragma once

#include "analysis/evidence/consistency.h"
#include "analysis/evidence/word.h"
#include "montecarlo/engine/study_statistics.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// A verdict with everything it rests on, as docs/formats.md describes `nees` and `nis`. Internal to the
/// writers of JSON.
Json verdict_json(const ConsistencyVerdict& verdict);

/// How many runs ended in each of the outcomes, by its name.
Json outcome_counts_json(const StudyStatistics& statistics);

/// An array of the runs in which an iteration of the filter ended before it had settled: `run`, `steps`.
Json not_converged_json(std::span<const RunNotConverged> runs);

/// The object `word`: the verdict over everything, and what it joins.
Json word_json(const Word& word);

}  // namespace credence::internal
