#include "montecarlo/engine/experiment.h"

namespace credence {

RunTrace Experiment::trace(std::int64_t run) const {
  RunTrace trace = describe_world();
  trace.layout = layout_;
  trace.run = run;
  trace.outcome = visit(run, [&](const TraceStep& step) { trace.steps.push_back(step); });
  return trace;
}

}  // namespace credence
