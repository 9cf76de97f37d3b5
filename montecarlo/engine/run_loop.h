#pragma once

#include <algorithm>
#include <cstdint>

#include "core/types.h"
#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// Plays the runs first_run … first_run + runs − 1, one after the other, each until it ends or fails, and
/// shows them to the observer, if there is one. `run` has start(r), step(k) for k = 1 …, which returns an
/// Outcome, show(observer, k), which shows step k, and add_to(StepStatistics&, RunTotals&).
template <class Run>
StudyStatistics play_runs(Run& run, std::int64_t first_run, std::int64_t runs, Index steps,
                          ChunkObserver* observer) {
  StudyStatistics statistics;
  statistics.runs = runs;
  statistics.steps.resize(static_cast<std::size_t>(steps));
  statistics.reserve_runs(runs);
  for (std::int64_t r = first_run; r < first_run + runs; ++r) {
    run.start(r);
    if (observer != nullptr) observer->begin_runs(1);
    RunTotals sums;
    Outcome outcome = Outcome::ok;
    Index k = 1;
    for (; k <= steps; ++k) {
      outcome = run.step(k);
      if (outcome != Outcome::ok) {
        statistics.failures.push_back({r, k, outcome});
        break;
      }
      if (observer != nullptr) run.show(*observer, k);
      run.add_to(statistics.steps[static_cast<std::size_t>(k - 1)], sums);
    }
    if (observer != nullptr) observer->end_run(outcome, std::min(k, steps), 0);
    sums.add_to(statistics, r, outcome != Outcome::ok);
  }
  return statistics;
}

}  // namespace credence::internal
