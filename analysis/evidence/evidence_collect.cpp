#include "analysis/evidence/evidence_collect.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "analysis/evidence/evidence_recorder.h"
#include "core/parallel_tasks.h"

namespace credence {
namespace {

Evidence play(const Experiment& experiment, std::int64_t first, std::int64_t last) {
  EvidenceRecorder recorder(experiment.layout());
  for (std::int64_t run = first; run < last; ++run) {
    recorder.begin_run();
    std::int64_t steps = 0;
    const Outcome outcome = experiment.visit(run, [&](const TraceStep& step) {
      steps = step.step;
      if (step.step > 0 && step.outcome == Outcome::ok) recorder.add(step);
    });
    recorder.end_run(outcome, steps);
  }
  return recorder.take();
}

}  // namespace

std::int64_t evidence_runs(Index state_dim, std::int64_t steps, std::int64_t runs) {
  constexpr std::int64_t kMost = 1024;
  constexpr double kOperations = 2e10;
  const auto n = static_cast<double>(state_dim);
  const double of_a_run = static_cast<double>(steps) * (n * n * n + 1e4);
  const auto affordable = static_cast<std::int64_t>(std::min(1e9, kOperations / of_a_run));
  return std::min(runs, std::clamp(affordable / kChunkRuns * kChunkRuns, kChunkRuns, kMost));
}

std::optional<Evidence> collect_evidence(const Experiment& experiment, std::int64_t runs,
                                         const EngineOptions& options) {
  const std::int64_t chunks = (runs + kChunkRuns - 1) / kChunkRuns;
  std::vector<Evidence> parts(static_cast<std::size_t>(chunks));
  StudyProgress progress{.runs_total = runs};
  std::mutex mutex;
  for_each_task(chunks, options.threads, options.stop, [&](std::int64_t chunk) {
    const std::int64_t first = chunk * kChunkRuns, last = std::min(runs, first + kChunkRuns);
    parts[static_cast<std::size_t>(chunk)] = play(experiment, first, last);
    const std::lock_guard lock(mutex);
    progress.runs_done += last - first;
    if (options.progress) options.progress(progress);
  });
  if (progress.runs_done < runs) return std::nullopt;
  Evidence all;
  for (Evidence& part : parts) all.merge(std::move(part));
  return all;
}

}  // namespace credence
