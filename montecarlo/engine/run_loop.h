#pragma once

#include <cstdint>

#include "core/types.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence {

/// Adds the runs first_run … first_run + runs − 1, one after the other, each until it ends or fails. `run`
/// has start(r), step(k) for k = 1 …, which returns an Outcome, now(), the TraceStep of the last step, and
/// add_to(StepStatistics&).
template <class Run>
void add_runs(Run& run, std::int64_t first_run, std::int64_t runs, Index steps, StudyStatistics& statistics) {
  for (std::int64_t r = first_run; r < first_run + runs; ++r) {
    run.start(r);
    RunSum sum;
    Index k = 1;
    for (; k <= steps; ++k) {
      const Outcome outcome = run.step(k);
      if (outcome != Outcome::ok) {
        statistics.failures.push_back({r, k, outcome});
        break;
      }
      run.add_to(statistics.steps[static_cast<std::size_t>(k - 1)]);
      sum.add(run.now().nees, run.now().nees_dof);
    }
    if (k > steps) sum.add_to(statistics.nees_of_runs);
  }
}

}  // namespace credence
