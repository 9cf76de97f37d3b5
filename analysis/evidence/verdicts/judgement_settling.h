#pragma once

#include <cstddef>

#include "analysis/evidence/verdicts/judgement.h"

/// @file
/// How much the runs at hand can tell, and how many would tell what they cannot.

namespace credence::internal {

/// The independent steps that the NEES of a run is worth; NaN unless there are enough whole runs of one
/// length for a correlation in time.
double effective_steps_of(const RunSums& runs, std::size_t steps);

/// The correlation time of NEES as the errors of few runs tell it (memory_of_squares), in rows; NaN where
/// they were not kept of all rows and states.
double memory_in_rows(const Evidence& evidence);

/// The runs that would decide, for values that are white or worth so many independent steps.
SettlingRuns settle(const ConsistencyVerdict& verdict, bool white, double effective_steps);

/// Of runs that are too few to compare, or of different lengths: by the correlation within them, and by their
/// averages as far as they scatter.
SettlingRuns settle_few(const Evidence& evidence, const StudyStatistics& statistics,
                        const SkewedMoments& stretches, const Judgement& judged);

/// Adds to the verdict what the course of one run in time says, NEES / dof of its rows; memory:
/// memory_in_rows.
void judge_single_run(const Evidence& evidence, std::span<const double> nees, double memory,
                      Judgement& judged);

/// Leaves one run open, whose average is not tested, and says how many like it would tell.
void leave_open(const Evidence& evidence, Judgement& judged);

}  // namespace credence::internal
