#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/sequential/sequential.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// Watches the chunks of one study for its stop rule; what it decides depends on the chunks alone, in their
/// order.
class SequentialStudy {
 public:
  explicit SequentialStudy(const Scenario& scenario);

  /// For StudyTask::enough.
  bool look(const StudyStatistics& chunk, const StudyStatistics& prefix);

  /// The last look; `stop` is false when the study ended for another reason.
  const StopDecision& decision() const { return decision_; }

 private:
  StopRule rule_;
  std::int64_t most_runs_;
  RunBetting betting_;
  StopDecision decision_;
};

/// A configuration, ready to be played.
struct StudyToPlay {
  std::string id;  ///< configuration_id of its scenario
  const Scenario* scenario = nullptr;
  const Experiment* experiment = nullptr;
  EvidenceCollector* evidence = nullptr;  ///< none: nothing but the statistics
};

/// What came of a configuration.
struct PlayedStudy {
  StudyResult result;
  std::optional<StopDecision> stop;  ///< the last look, of a scenario with a stop rule
};

/// Plays configurations until their runs are done, their stop rules say enough or their time is over. One
/// result for each, of one that was stopped before without runs.
std::vector<PlayedStudy> play_studies(std::span<const StudyToPlay> studies, const EngineOptions& options);

}  // namespace credence::internal
