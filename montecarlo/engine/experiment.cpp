#include "montecarlo/engine/experiment.h"

#include <algorithm>
#include <limits>

namespace credence {

using namespace internal;

std::vector<Outcome> Experiment::visit_runs(std::int64_t first_run, std::int64_t runs,
                                            const RunsVisitor& take) const {
  std::vector<Outcome> outcomes;
  for (std::int64_t run = first_run; run < first_run + runs; ++run) {
    outcomes.push_back(visit(run, [&](const TraceStep& step) { take(run, step); }));
  }
  return outcomes;
}

std::optional<StudyStatistics> Experiment::show_chunk(std::int64_t first_run, std::int64_t runs,
                                                      ChunkObserver& observer) const {
  std::vector<std::int64_t> last;
  for (std::int64_t done = 0; done < runs; done += std::ssize(last)) {
    const std::int64_t first = first_run + done;
    last.assign(static_cast<std::size_t>(std::min(runs_side_by_side(), runs - done)), 0);
    observer.begin_runs(std::ssize(last));
    const std::vector<Outcome> outcomes =
        visit_runs(first, std::ssize(last), [&](std::int64_t run, const TraceStep& step) {
          const auto i = static_cast<std::size_t>(run - first);
          last[i] = step.step;
          if (step.step > 0 && step.outcome == Outcome::ok) observer.add(step, i);
        });
    for (std::size_t i = 0; i < last.size(); ++i) observer.end_run(outcomes[i], last[i], i);
  }
  return std::nullopt;
}

RunTrace Experiment::trace(std::int64_t run) const {
  return *trace_to_draw(run, std::numeric_limits<double>::infinity());
}

std::optional<RunTrace> Experiment::trace_to_draw(std::int64_t run, double most_bytes) const {
  RunTrace trace = describe_world();
  trace.layout = layout_;
  trace.run = run;
  double bytes = 0.0;
  trace.outcome = visit(run, [&](const TraceStep& step) {
    bytes += static_cast<double>(sizeof(double)) *
             static_cast<double>(step.P.size() + step.K.size() + step.S().size());
    if (bytes > most_bytes)
      trace.steps = {};
    else
      trace.steps.push_back(step);
  });
  if (bytes > most_bytes) return std::nullopt;
  return trace;
}

}  // namespace credence
