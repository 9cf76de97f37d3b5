#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence::internal {

class Ranks;
class ResultStore;

/// Runs of one chunk: the atom of work, of storage and of merging. Fixed, because it fixes the bits.
inline constexpr std::int64_t kChunkRuns = 64;

/// Looks at the chunk that has just lengthened the unbroken sequence of chunks from run 0 on, and at the sums
/// of that sequence; true ends the study there. Called in the order of the chunks, by one thread at a time.
using StudyWatch = std::function<bool(const StudyStatistics& chunk, const StudyStatistics& prefix)>;

/// A configuration to run.
struct StudyTask {
  std::string id;  ///< under which its chunks are stored; unused without a store
  const Experiment* experiment = nullptr;
  std::int64_t runs = 0;     ///< at most
  StudyWatch enough = {};    ///< may end it before
  double max_seconds = 0.0;  ///< > 0: no chunk is begun later than this after the first one
  std::int64_t steps = 0;    ///< of a run, for the progress within a chunk; 0: not told
  /// Plays a chunk in the place of the experiment, with the same bits; empty: nobody does. Thread-safe.
  std::function<StudyStatistics(std::int64_t first_run, std::int64_t runs)> play{};
  /// What is stored beside a chunk just played, and who takes it where the chunk was there, and tells whether
  /// it may be of its runs; empty: nothing. Thread-safe.
  std::function<std::vector<std::byte>(std::int64_t first_run, std::int64_t runs)> companion{};
  std::function<bool(std::int64_t first_run, std::int64_t runs, std::span<const std::byte>)> found{};
  /// With ranks, so many first runs stay on rank 0, as `play` keeps more of them than their statistics.
  std::int64_t kept_runs = 0;
};

/// How far a call of run_studies has come.
struct StudyProgress {
  std::int64_t runs_done = 0;    ///< in this call, stored ones not included
  std::int64_t runs_stored = 0;  ///< found in the store
  std::int64_t runs_total = 0;   ///< of all tasks
  double runs_in_hand = 0.0;     ///< of chunks in hand here, by their steps: lost if the call ends now
};

struct EngineOptions {
  int threads = 0;                          ///< 0: one for each processor
  const std::atomic<bool>* stop = nullptr;  ///< set: the chunks in hand are dropped, no further one is begun
  ResultStore* store = nullptr;             ///< chunks found there are not run again, new ones are put there
  std::function<void(const StudyProgress&)>
      progress{};             ///< after every chunk, and within long ones; by one thread at a time
  int shard = 1, shards = 1;  ///< run only every shards-th chunk, beginning with this one
  Ranks* ranks = nullptr;     ///< share the chunks among these; `store` and `progress` are of rank 0
};

/// The statistics of the longest unbroken sequence of chunks from run 0 on, so that what is reported is the
/// same whatever was computed beyond it.
struct StudyResult {
  StudyStatistics statistics;
  bool complete = false;             ///< all runs were made, or `enough` was
  bool timed_out = false;            ///< ended by max_seconds
  std::int64_t shard_runs = 0;       ///< of the chunks of this process's shard, or of all without one
  std::int64_t shard_runs_done = 0;  ///< of those, found in the store or made
};

/// Runs all tasks in parallel, one result for each in their order.
///
/// The bits depend on the tasks alone: chunks are merged in the order of their runs. An exception of an
/// experiment or of the store ends the call after the chunks begun, and is thrown on. On ranks other than 0
/// the results have no runs; see for_each_shared_task.
std::vector<StudyResult> run_studies(std::span<const StudyTask> tasks, const EngineOptions& options);

}  // namespace credence::internal
