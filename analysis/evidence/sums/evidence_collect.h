#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "analysis/evidence/sums/evidence.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// Runs of a study that its further evidence is taken of: at most 1,024, fewer where a state of n dimensions
/// makes them dear, and whole chunks.
std::int64_t evidence_runs(Index state_dim, std::int64_t steps, std::int64_t runs);

/// The evidence of the first runs of a study, of each chunk from whoever has it first: a result store, the
/// engine, which then need not play it twice, or take(). Safe to use from several threads. `experiment` must
/// live as long.
class EvidenceCollector {
 public:
  /// No evidence is asked for beyond the first `most` runs.
  EvidenceCollector(const Experiment& experiment, std::int64_t most) : experiment_(experiment), most_(most) {}

  /// Experiment::run_chunk, with the same bits, which keeps the evidence of an early chunk; of an experiment
  /// that does not show its steps as it runs they are played once more.
  StudyStatistics play(std::int64_t first_run, std::int64_t runs);

  /// What a result store keeps of the evidence of a chunk that was played; empty where there is none, or too
  /// much.
  std::vector<std::byte> stored(std::int64_t first_run, std::int64_t runs);
  /// Takes what a store has of a chunk; of another version nothing, and the chunk will be played. False where
  /// it is of another number of runs, and is not taken.
  bool take_stored(std::int64_t first_run, std::int64_t runs, std::span<const std::byte> bytes);
  /// Has an engine keep the evidence in its store, and take it from there.
  void keep_with(StudyTask& task);

  /// The evidence of the first `runs` runs, those played that were not yet; the bits do not depend on the
  /// threads, nor on who played. Of `options` only threads, stop and progress count. Nothing when stopped
  /// before all were played: the evidence of some of the runs would not be the same twice.
  std::optional<Evidence> take(std::int64_t runs, const EngineOptions& options = {});

  /// So many first runs, of whole chunks, are there.
  std::int64_t first_runs() const;

 private:
  using ChunkRuns = std::pair<std::int64_t, std::int64_t>;  ///< the first run, and how many

  std::optional<StudyStatistics> record(std::int64_t first_run, std::int64_t runs);
  bool has(const ChunkRuns& chunk);

  const Experiment& experiment_;
  std::int64_t most_;
  mutable std::mutex mutex_;
  std::map<ChunkRuns, Evidence> chunks_;
};

}  // namespace credence::internal
