#pragma once

#include <cstdint>
#include <utility>

#include "montecarlo/engine/shown_experiment.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence::internal {

/// The layout that a world tells, with what it leaves to be guessed: angles and blocks by the names of the
/// states
/// ("heading:angle" is an angle in rad, "pose.x" of a block "pose"), innovations whole. Throws
/// std::invalid_argument for names that are there twice, and numbers that do not fit.
RunLayout completed(RunLayout layout);

/// Fills what a step shows of NEES and NIS, from its error, P and innovations.
void normalise_step(TraceStep& step);

/// An experiment whose statistics are taken from what its visits show: NEES, NIS and the trace.
class VisitedExperiment : public ShownExperiment {
 public:
  VisitedExperiment(RunLayout layout, std::int64_t steps)
      : ShownExperiment(std::move(layout)), steps_(steps) {}

  std::int64_t steps() const { return steps_; }

 private:
  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const final;

  std::int64_t steps_;
};

}  // namespace credence::internal
