#pragma once

#include "core/filters/linear_estimators.h"
#include "montecarlo/worlds/linear/linear_experiment.h"

namespace credence {

/// Many runs of the Rauch-Tung-Striebel smoother after a Kalman filter: at each step what all measurements of
/// the run tell. It has no innovations.
class SmootherExperiment final : public Experiment {
 public:
  /// Throws std::invalid_argument where S of the filter is not positive definite at some step.
  SmootherExperiment(const LinearProblem& problem, Index steps, NoiseSource source);

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override;
  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  RunTrace describe_world() const override { return filter_.describe_world(); }

 private:
  Index steps_;
  LinearExperiment filter_;
  RtsSmoother smoother_;
  std::vector<Matrix> whitening_;  ///< of Pˢ_k
};

}  // namespace credence
