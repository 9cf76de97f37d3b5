#pragma once

#include "analysis/evidence/sequential.h"
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

}  // namespace credence::internal
