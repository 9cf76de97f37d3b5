#pragma once

#include <cstdint>

#include "montecarlo/engine/engine.h"

namespace credence::internal {

/// The statistics of the first runs of an experiment.
inline StudyStatistics study_of_runs(const Experiment& experiment, std::int64_t runs, int threads) {
  const StudyTask task{.id = {}, .experiment = &experiment, .runs = runs};
  return run_studies({&task, 1}, {.threads = threads}).front().statistics;
}

}  // namespace credence::internal
