#pragma once

#include "analysis/evidence/study_analysis.h"
#include "reports/render/json_numbers.h"

/// @file
/// What the documents of studies, of logs and of replays have in common (docs/formats.md).

namespace credence::internal {

/// A verdict with everything it rests on, as `nees` and `nis`.
Json verdict_json(const ConsistencyVerdict& verdict);

/// The object `word`: the verdict over everything, and what it joins.
Json word_json(const Word& word);

/// The object `battery` of a study or of logs.
Json judgement_json(const Judgement& judgement);

/// The name of the block, or null.
Json responsible_block_json(const Judgement& judgement);

/// Curves over the steps: `covariance`, and of errors `rmse`.
Json covariance_json(const CovarianceCurves& curves);
Json errors_json(const ErrorCurves& curves);

/// How many runs ended in each of the outcomes, by its name.
Json outcome_counts_json(const StudyStatistics& statistics);

/// `run`, `step` and `outcome` of a run that failed.
Json failure_json(const RunFailure& failure);

/// An array of the runs in which an iteration of the filter ended before it had settled: `run`, `steps`.
Json not_converged_json(std::span<const RunNotConverged> runs);

}  // namespace credence::internal
