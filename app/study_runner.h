#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "analysis/evidence/sums/play_studies.h"
#include "app/common_options.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// A configuration under its id, ready to run.
struct Configuration {
  std::string id;
  Scenario scenario;
  std::unique_ptr<Experiment> experiment;
  /// Where it is to be explained: takes the evidence while the engine plays.
  std::unique_ptr<EvidenceCollector> evidence{};
};

/// Throws std::invalid_argument naming the key where a chunk of this scenario is more than a store takes.
void require_storable(const Scenario& scenario);

/// Throws StoreError where the store that was written is no longer in its folder: reports are written after
/// the last commit, which sees that by itself.
void require_stored(const std::filesystem::path& directory);

Configuration make_configuration(const Scenario& scenario);

/// Has its evidence taken while the engine plays, kept in its store and taken from there.
void take_evidence(Configuration& configuration);

/// Which part of the chunks this process runs.
struct Shard {
  int number = 1, of = 1;
};

/// Judges it; see analyse_study.
StudyAnalysis analyse(const Configuration& configuration, PlayedStudy result);

/// Adds the tests that explain the verdicts, the verdict over all blocks and the bound on the errors, for
/// which the first runs are played where `evidence` has not seen them; an interruption leaves it
/// incomplete.
void explain(StudyAnalysis& analysis, const Configuration& configuration, const CommonOptions& options);

/// Runs configurations with progress, interrupt and, if `store_directory` is not empty, a store that belongs
/// to the canonical text. One result for each, of a helper of other ranks without runs.
std::vector<PlayedStudy> run_configurations(std::span<const Configuration> configurations,
                                            const std::string& canonical,
                                            const std::filesystem::path& store_directory,
                                            const std::string& what, const CommonOptions& options,
                                            Shard shard = {});

/// What a store holds of these configurations so far: one result for each, and nothing is run.
std::vector<PlayedStudy> stored_results(std::span<const Configuration> configurations, ResultStore& store);

/// The exit code of finished studies: interrupted, failed runs, inconsistent verdicts, in this order.
int study_exit_code(bool complete, bool any_failed, bool any_inconsistent, const CommonOptions& options);

}  // namespace credence::internal
