#include "analysis/evidence/sums/evidence_collect.h"

#include <algorithm>
#include <stdexcept>

#include "analysis/evidence/sums/evidence_bytes.h"
#include "analysis/evidence/sums/evidence_recorder.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// Hands what a chunk shows to a recorder.
class Recording final : public ChunkObserver {
 public:
  Recording(const RunLayout& layout, bool few) : recorder_(layout, few) {}
  void begin_runs(std::int64_t runs) override { recorder_.begin_runs(runs); }
  void add(const Step& step, std::size_t i) override { recorder_.add(step, i); }
  void add(const NormalisedStep& step, std::size_t i) override { recorder_.add(step, i); }
  void end_run(Outcome outcome, std::int64_t step, std::size_t i) override {
    recorder_.end_run(outcome, step, i);
  }
  Evidence take() { return recorder_.take(); }

 private:
  EvidenceRecorder recorder_;
};

}  // namespace

std::int64_t evidence_runs(Index state_dim, std::int64_t steps, std::int64_t runs) {
  constexpr std::int64_t kMost = 1024;
  constexpr double kOperations = 2e10;
  const auto n = static_cast<double>(state_dim);
  const double of_a_run = static_cast<double>(steps) * (n * n * n + 1e4);
  const auto affordable = static_cast<std::int64_t>(std::min(1e9, kOperations / of_a_run));
  return std::min(runs, std::clamp(affordable / kChunkRuns * kChunkRuns, kChunkRuns, kMost));
}

StudyStatistics EvidenceCollector::play(std::int64_t first_run, std::int64_t runs) {
  if (first_run >= most_) return experiment_.run_chunk(first_run, runs);
  if (experiment_.shows_as_it_runs()) return record(first_run, runs).value();
  StudyStatistics statistics = experiment_.run_chunk(first_run, runs);
  const PulseScope unheard([](std::int64_t) {});  // these steps were counted
  record(first_run, runs);
  return statistics;
}

std::optional<StudyStatistics> EvidenceCollector::record(std::int64_t first_run, std::int64_t runs) {
  Recording recording(experiment_.layout(), first_run + runs <= StretchSums::kMostRuns);
  std::optional<StudyStatistics> statistics = experiment_.show_chunk(first_run, runs, recording);
  Evidence evidence = recording.take();
  const std::lock_guard lock(mutex_);
  chunks_.insert_or_assign({first_run, runs}, std::move(evidence));
  return statistics;
}

std::vector<std::byte> EvidenceCollector::stored(std::int64_t first_run, std::int64_t runs) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  const std::lock_guard lock(mutex_);
  const auto found = chunks_.find({first_run, runs});
  if (found == chunks_.end()) return {};
  std::vector<std::byte> bytes = to_bytes(found->second);
  return bytes.size() <= kMostBytes ? bytes : std::vector<std::byte>();
}

bool EvidenceCollector::take_stored(std::int64_t first_run, std::int64_t runs,
                                    std::span<const std::byte> bytes) {
  if (first_run >= most_) return true;
  Evidence evidence;
  try {
    evidence = evidence_from_bytes(bytes, experiment_.layout());
  } catch (const std::runtime_error&) {
    return true;
  }
  if (evidence.study.runs != runs) return false;
  const std::lock_guard lock(mutex_);
  chunks_.insert_or_assign({first_run, runs}, std::move(evidence));
  return true;
}

void EvidenceCollector::keep_with(StudyTask& task) {
  task.play = [this](std::int64_t first, std::int64_t runs) { return play(first, runs); };
  task.kept_runs = most_;
  task.companion = [this](std::int64_t first, std::int64_t runs) { return stored(first, runs); };
  task.found = [this](std::int64_t first, std::int64_t runs, std::span<const std::byte> bytes) {
    return take_stored(first, runs, bytes);
  };
}

std::optional<Evidence> EvidenceCollector::take(std::int64_t runs, const EngineOptions& options) {
  const std::int64_t chunks = (runs + kChunkRuns - 1) / kChunkRuns;
  const auto key_of = [runs](std::int64_t chunk) {
    const std::int64_t first = chunk * kChunkRuns;
    return ChunkRuns{first, std::min(kChunkRuns, runs - first)};
  };
  StudyProgress progress{.runs_total = runs};
  std::vector<std::int64_t> missing;  // what is there was played, and no stop takes it away
  for (std::int64_t chunk = 0; chunk < chunks; ++chunk) {
    if (has(key_of(chunk)))
      progress.runs_done += key_of(chunk).second;
    else
      missing.push_back(chunk);
  }
  std::mutex mutex;
  for_each_task(std::ssize(missing), options.threads, options.stop, [&](std::int64_t i) {
    const auto [first, count] = key_of(missing[static_cast<std::size_t>(i)]);
    record(first, count);
    const std::lock_guard lock(mutex);
    progress.runs_done += count;
    if (options.progress) options.progress(progress);
  });
  if (progress.runs_done < runs) return std::nullopt;
  Evidence all;
  for (std::int64_t chunk = 0; chunk < chunks; ++chunk) all.merge(std::move(chunks_.at(key_of(chunk))));
  chunks_.clear();
  return all;
}

std::int64_t EvidenceCollector::first_runs() const {
  const std::lock_guard lock(mutex_);
  std::int64_t runs = 0;
  while (chunks_.contains({runs, kChunkRuns})) runs += kChunkRuns;
  return runs;
}

bool EvidenceCollector::has(const ChunkRuns& chunk) {
  const std::lock_guard lock(mutex_);
  return chunks_.contains(chunk);
}

}  // namespace credence::internal
