#pragma once

#include "analysis/evidence/sequential.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"

namespace credence {

/// Watches the chunks of one study for its stop rule; what it decides depends on the chunks alone, in their
/// order.
///
/// The precision of the mean NEES comes from the averages of whole chunks, of 64 runs each, which are
/// independent and nearly Gaussian: so it needs StopRule::min_runs of them.
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
  Moments chunk_averages_;
  StopDecision decision_;
};

}  // namespace credence
