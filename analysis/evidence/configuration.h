#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "analysis/evidence/sums/play_studies.h"
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

Configuration make_configuration(const Scenario& scenario);

/// Has its evidence taken while the engine plays, kept in its store and taken from there.
void take_evidence(Configuration& configuration);

/// Plays them: see play_studies.
std::vector<PlayedStudy> play(std::span<const Configuration> configurations, const EngineOptions& options);

/// What a store holds of these configurations so far: one result for each, and nothing is run.
std::vector<PlayedStudy> stored_results(std::span<const Configuration> configurations, ResultStore& store);

/// Judges it; see analyse_study.
StudyAnalysis analyse(const Configuration& configuration, PlayedStudy result);

/// Judges those that have runs.
std::vector<StudyAnalysis> analyses_of(std::span<const Configuration> configurations,
                                       std::vector<PlayedStudy> results);

/// Adds the tests that explain the verdicts, the verdict over all blocks and the bound on the errors, for
/// which the first runs are played where `evidence` has not seen them; an interruption leaves it
/// incomplete.
void explain(StudyAnalysis& analysis, const Configuration& configuration, const EngineOptions& options);

}  // namespace credence::internal
