#include "montecarlo/engine/experiment.h"

namespace credence {

std::vector<Outcome> Experiment::visit_runs(std::int64_t first_run, std::int64_t runs,
                                            const RunsVisitor& take) const {
  std::vector<Outcome> outcomes;
  for (std::int64_t run = first_run; run < first_run + runs; ++run) {
    outcomes.push_back(visit(run, [&](const TraceStep& step) { take(run, step); }));
  }
  return outcomes;
}

RunTrace Experiment::trace(std::int64_t run) const {
  RunTrace trace = describe_world();
  trace.layout = layout_;
  trace.run = run;
  trace.outcome = visit(run, [&](const TraceStep& step) { trace.steps.push_back(step); });
  return trace;
}

}  // namespace credence
