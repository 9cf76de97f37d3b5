#pragma once

#include "datasets/logs/log_sink.h"
#include "datasets/replay/replay_result.h"

namespace credence::internal {

/// Hands over a replay as the one run of a log, for the judge of logs.
///
/// A row has an innovation, a comparison with the reference, or both: that with the last innovation before
/// it. P is the filter's with the variances of the reference added. Without a gate every observation is an
/// innovation, given those before it in its batch: ν = L_ii u_i, S = L_ii L_iiᵀ, independent of each other
/// for a consistent filter. With one the first of each batch alone, of which the law within the gate is
/// known.
void read_replay(const ReplayResult& replay, LogSink& sink);

/// The NIS beyond which read_replay has no innovation; ∞ without a gate.
double gate_of(const ReplayResult& replay);

}  // namespace credence::internal
