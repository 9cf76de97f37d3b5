#include "analysis/evidence/stored_study.h"

#include <fmt/format.h>

#include <algorithm>

#include "montecarlo/engine/result_store_error.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {

namespace fs = std::filesystem;

namespace {

StoreError nothing_stored(const fs::path& directory) {
  return StoreError(directory.string() + ": no runs are stored yet");
}

}  // namespace

std::int64_t StoredStudy::runs() const {
  std::int64_t sum = 0;
  for (const PlayedStudy& result : results) sum += result.result.statistics.runs;
  return sum;
}

std::int64_t StoredStudy::runs_asked() const {
  std::int64_t sum = 0;
  for (const Configuration& c : configurations) sum += c.scenario.most_runs();
  return sum;
}

std::vector<fs::path> study_directories(const fs::path& path) {
  if (ResultStore::exists(path)) return {path};
  std::vector<fs::path> directories;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    if (ResultStore::exists(entry.path())) directories.push_back(entry.path());
  }
  if (directories.empty()) {
    throw StoreError(
        fmt::format("{}: holds no stored results; run and sweep make such folders, with --out (other "
                    "commands make their pages and figures again when they are run again; of `check` the "
                    "document of --format json is compared)",
                    path.string()));
  }
  std::ranges::sort(directories);
  return directories;
}

StoredStudy read_study(const fs::path& directory) {
  ResultStore store = ResultStore::open_to_read(directory);
  StoredStudy study;
  study.directory = directory;
  study.tool_version = store.tool_version();
  const std::string scenario = store.scenario();
  if (scenario.empty()) throw nothing_stored(directory);
  study.plan = plan_sweep(read_scenario_text(scenario, directory.string()));
  if (const std::string name = store.name(); !name.empty()) study.plan.name = name;
  for (SweepPoint& point : study.plan.points) {
    point.scenario.name = study.plan.name;
    study.configurations.push_back(make_configuration(point.scenario));
  }
  if (study.configurations.size() == 1) take_evidence(study.configurations.front());
  study.results = stored_results(study.configurations, store);
  study.writer = ResultStore::writer(directory);
  return study;
}

RunsBehindGaps runs_behind_gaps(const StoredStudy& study) {
  const ResultStore store = ResultStore::open_to_read(study.directory);
  RunsBehindGaps behind;
  for (std::size_t i = 0; i < study.results.size(); ++i) {
    const StudyResult& result = study.results[i].result;
    const std::int64_t judged = result.statistics.runs;
    const std::int64_t asked = study.configurations[i].scenario.most_runs();
    if (result.complete) continue;
    for (const ChunkKey& chunk : store.chunks(study.configurations[i].id)) {
      // A study may have been run with fewer or more runs.
      if (chunk.first_run < judged || chunk.runs != std::min(kChunkRuns, asked - chunk.first_run)) continue;
      if (chunk.first_run == judged) break;  // it has come meanwhile
      behind.add(chunk, judged);
    }
  }
  return behind;
}

std::string missing_text(const StoredStudy& study, const RunsBehindGaps& behind) {
  if (study.is_sweep()) return "others";
  return fmt::format("runs {} to {}", behind.first_missing, behind.last_missing);
}

void require_runs(const StoredStudy& study) {
  if (study.runs() > 0) return;
  const RunsBehindGaps behind = runs_behind_gaps(study);
  if (behind.count == 0) throw nothing_stored(study.directory);
  throw StoreError(
      fmt::format("{}: none of the {} runs that are stored can be judged yet, as {} before them are missing",
                  study.directory.string(), behind.count, missing_text(study, behind)));
}

std::vector<StudyAnalysis> analyse(const StoredStudy& study) {
  return analyses_of(study.configurations, study.results);
}

}  // namespace credence::internal
