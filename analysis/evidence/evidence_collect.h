#pragma once

#include <optional>

#include "analysis/evidence/evidence.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"

namespace credence {

/// Runs of a study that its further evidence is taken of: at most 1,024, fewer where a state of n dimensions
/// makes them dear, and whole chunks.
///
/// Every run is played again in full for it, so the number is bounded by what that costs.
std::int64_t evidence_runs(Index state_dim, std::int64_t steps, std::int64_t runs);

/// Plays the first `runs` runs and accumulates; the bits do not depend on the threads. Of `options` only
/// threads, stop and progress count. Nothing when stopped: the evidence of some of the runs would not be the
/// same twice.
std::optional<Evidence> collect_evidence(const Experiment& experiment, std::int64_t runs,
                                         const EngineOptions& options = {});

}  // namespace credence
