#pragma once

#include <algorithm>
#include <cstdint>

#include "core/types.h"
#include "montecarlo/engine/experiment.h"

namespace credence {

/// Adds the runs first_run … first_run + runs − 1, one after the other, each until it ends or fails, and
/// shows them to the observer, if there is one. `run` has start(r), step(k) for k = 1 …, which returns an
/// Outcome, now(), the TraceStep of step k, and add_to(StepStatistics&).
template <class Run>
void add_runs(Run& run, std::int64_t first_run, std::int64_t runs, Index steps, StudyStatistics& statistics,
              ChunkObserver* observer = nullptr) {
  for (std::int64_t r = first_run; r < first_run + runs; ++r) {
    run.start(r);
    if (observer != nullptr) observer->begin_runs(1);
    RunSum sum;
    Outcome outcome = Outcome::ok;
    Index k = 1;
    for (; k <= steps; ++k) {
      outcome = run.step(k);
      if (outcome != Outcome::ok) {
        statistics.failures.push_back({r, k, outcome});
        break;
      }
      if (observer != nullptr) observer->add(run.now(), 0);
      run.add_to(statistics.steps[static_cast<std::size_t>(k - 1)]);
      sum.add(run.now().nees, run.now().nees_dof);
    }
    if (observer != nullptr) observer->end_run(outcome, std::min(k, steps), 0);
    if (k > steps) sum.add_to(statistics.nees_of_runs);
  }
}

}  // namespace credence
