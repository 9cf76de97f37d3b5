#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/configuration.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/sweep_plan.h"

namespace credence::internal {

/// What a folder holds of a study so far, read without disturbing the process that may be writing there.
struct StoredStudy {
  std::filesystem::path directory;
  SweepPlan plan;  ///< of a study without [sweep] its one point
  std::vector<Configuration> configurations;
  std::vector<PlayedStudy> results;  ///< one for each configuration; without runs where none are stored
  std::string tool_version;
  std::optional<std::int64_t> writer;  ///< the process that goes on with it now

  bool is_sweep() const { return !plan.axes.empty(); }
  std::int64_t runs() const;        ///< stored, without a gap from the first on
  std::int64_t runs_asked() const;  ///< of all configurations
};

/// The folders of studies that a path means: itself, or those in it, in the order of their names.
///
/// Throws StoreError where there is none.
std::vector<std::filesystem::path> study_directories(const std::filesystem::path& path);

/// Reads one. Throws StoreError and ScenarioError.
StoredStudy read_study(const std::filesystem::path& directory);

/// Runs that are stored and not judged, as runs before them are missing.
struct RunsBehindGaps {
  std::int64_t count = 0, first_missing = 0, last_missing = -1;  ///< of the first gap

  void add(const ChunkKey& chunk, std::int64_t judged) {
    if (count == 0) first_missing = judged, last_missing = chunk.first_run - 1;
    count += chunk.runs;
  }
};
RunsBehindGaps runs_behind_gaps(const StoredStudy& study);
/// "runs 0 to 63", which are missing before them; of a sweep "others".
std::string missing_text(const StoredStudy& study, const RunsBehindGaps& behind);

/// Throws StoreError where there is nothing to judge: no runs are stored yet, or not the first ones.
void require_runs(const StoredStudy& study);

/// Judges those of its configurations that have runs; as `sweep` does, by NEES, NIS and the pose.
std::vector<StudyAnalysis> analyse(const StoredStudy& study);

}  // namespace credence::internal
