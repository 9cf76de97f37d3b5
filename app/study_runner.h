#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/configuration.h"
#include "analysis/evidence/stored_study.h"
#include "app/common_options.h"

namespace credence::internal {

/// Throws std::invalid_argument naming the key where a chunk of this scenario is more than a store takes.
void require_storable(const Scenario& scenario);

/// Throws StoreError where the store that was written is no longer in its folder: reports are written after
/// the last commit, which sees that by itself.
void require_stored(const std::filesystem::path& directory);

/// Which part of the chunks this process runs.
struct Shard {
  int number = 1, of = 1;
};

/// The same as explain, with progress and interrupt.
void explain(StudyAnalysis& analysis, const Configuration& configuration, const CommonOptions& options);

/// Judges a study of one configuration as `run` does: the first runs are played again, and the verdict joins
/// all blocks. Nothing where there are no runs yet, or the user ended it.
std::optional<StudyAnalysis> judge(const StoredStudy& study, const CommonOptions& options);

/// Runs configurations with progress, interrupt and, if `store_directory` is not empty, a store that belongs
/// to the canonical text. One result for each, of a helper of other ranks without runs.
std::vector<PlayedStudy> run_configurations(std::span<const Configuration> configurations,
                                            const std::string& canonical,
                                            const std::filesystem::path& store_directory,
                                            const std::string& what, const CommonOptions& options,
                                            Shard shard = {});

/// The exit code of finished studies: interrupted, failed runs, inconsistent verdicts, in this order.
int study_exit_code(bool complete, bool any_failed, bool any_inconsistent, const CommonOptions& options);

}  // namespace credence::internal
