#pragma once

#include <cstdint>

#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence {

/// Fills what a step shows of NEES and NIS, from its error, P and innovations.
void normalise_step(TraceStep& step);

/// The statistics of a chunk of runs of `experiment`, step by step as it shows them: NEES, NIS and the trace.
StudyStatistics visited_chunk(const Experiment& experiment, std::int64_t steps, std::int64_t first_run,
                              std::int64_t runs);

}  // namespace credence
