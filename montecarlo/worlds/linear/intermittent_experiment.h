#pragma once

#include "montecarlo/engine/experiment.h"
#include "montecarlo/lanes/intermittent_lanes.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/linear/linear_problem.h"

namespace credence::internal {

/// Many runs of a linear filter that misses measurements at random, so that every run has covariances and
/// gains of its own, or whose noise is late or not white and Gaussian: in lanes where IntermittentLanes
/// supports it, else one by one by LinearFilter.
///
/// A step without any measurement has no NIS. The true and the assumed R must be diagonal where measurements
/// are missed.
class IntermittentExperiment final : public Experiment {
 public:
  IntermittentExperiment(LinearProblem problem, Index steps, NoiseSource source);

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override;
  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  RunTrace describe_world() const override;
  bool shows_as_it_runs() const override { return !lanes_; }
  std::optional<StudyStatistics> show_chunk(std::int64_t first_run, std::int64_t runs,
                                            ChunkObserver& observer) const override;

  /// Whether the filter knows the true noise, which is white, and inflates nothing: its E[NEES] is then the
  /// number of states, its E[NIS] that of the measurements it has, whatever is missed, and whatever the law.
  bool is_optimal() const;

  const IntermittentProblem& problem() const { return problem_; }

 private:
  class Run;

  StudyStatistics play_lanes(std::int64_t first_run, std::int64_t runs) const;
  StudyStatistics play_matrices(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const;

  LinearProblem problem_;
  Index steps_;
  NoiseSource source_;
  bool lanes_;
};

}  // namespace credence::internal
