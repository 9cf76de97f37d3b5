#include "analysis/evidence/evidence_collect.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "analysis/evidence/evidence_recorder.h"
#include "core/parallel_tasks.h"

namespace credence {
namespace {

void record_run(const Experiment& experiment, std::int64_t run, EvidenceRecorder& recorder) {
  recorder.begin_run();
  std::int64_t steps = 0;
  const auto outcomes = experiment.visit_runs(run, 1, [&](std::int64_t, const TraceStep& step) {
    steps = step.step;
    if (step.step > 0 && step.outcome == Outcome::ok) recorder.add(step);
  });
  recorder.end_run(outcomes.front(), steps);
}

/// Runs that are played side by side, kept step by step until each can be recorded as a whole: the sums are
/// those of one run after the other. Long runs are taken fewer at a time.
class SideBySide {
 public:
  explicit SideBySide(const Experiment& experiment)
      : experiment_(experiment), most_(experiment.runs_side_by_side()) {}

  void record(std::int64_t first, std::int64_t last, EvidenceRecorder& recorder) {
    while (first < last) {
      const std::int64_t runs = std::min(most_, last - first);
      if (runs > 1) {
        record_together(first, runs, recorder);
      } else {
        record_run(experiment_, first, recorder);
      }
      first += runs;
    }
  }

 private:
  static constexpr double kMostDoubles = 2e7;  // 160 MB of a thread

  struct Kept {
    std::vector<Step> steps{};  ///< the first `size` are of this run; the others keep their memory
    std::size_t size = 0;
    std::int64_t last = 0;

    void add(const Step& step) {
      if (size == steps.size()) steps.emplace_back();
      steps[size++] = step;
    }
  };

  static double doubles_of(const Step& step) {
    double doubles = static_cast<double>(step.P.size() + step.error.size()) + 32.0;
    for (const Innovation& i : step.innovations) doubles += static_cast<double>(i.S.size() + i.nu.size());
    return doubles;
  }

  void record_together(std::int64_t first, std::int64_t runs, EvidenceRecorder& recorder) {
    kept_.resize(std::max(kept_.size(), static_cast<std::size_t>(runs)));
    for (Kept& run : kept_) run.size = 0;
    double doubles = 0.0;
    const std::vector<Outcome> outcomes =
        experiment_.visit_runs(first, runs, [&](std::int64_t run, const TraceStep& step) {
          Kept& kept = kept_[static_cast<std::size_t>(run - first)];
          kept.last = step.step;
          if (step.step == 0 || step.outcome != Outcome::ok) return;
          doubles += doubles_of(step);
          if (doubles <= kMostDoubles) kept.add(step);
        });
    const bool all = doubles <= kMostDoubles;
    if (!all) most_ = static_cast<std::int64_t>(kMostDoubles / doubles * static_cast<double>(runs));
    for (std::int64_t i = 0; i < runs; ++i) {
      if (!all) {
        record_run(experiment_, first + i, recorder);
        continue;
      }
      const Kept& run = kept_[static_cast<std::size_t>(i)];
      recorder.begin_run();
      for (std::size_t k = 0; k < run.size; ++k) recorder.add(run.steps[k]);
      recorder.end_run(outcomes[static_cast<std::size_t>(i)], run.last);
    }
  }

  const Experiment& experiment_;
  std::int64_t most_;
  std::vector<Kept> kept_;
};

Evidence play(const Experiment& experiment, std::int64_t first, std::int64_t last) {
  EvidenceRecorder recorder(experiment.layout());
  SideBySide(experiment).record(first, last, recorder);
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
