#pragma once

#include "core/filters/linear_estimators.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/plugged/plugged_statistics.h"

namespace credence::internal {

/// Many runs of the Rauch-Tung-Striebel smoother after a Kalman filter: at each step what all measurements of
/// the run tell. It has no innovations.
class SmootherExperiment final : public VisitedExperiment {
 public:
  /// Throws std::invalid_argument where S of the filter is not positive definite at some step.
  SmootherExperiment(const LinearProblem& problem, Index steps, NoiseSource source);

  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  RunTrace describe_world() const override { return filter_.describe_world(); }

 private:
  LinearExperiment filter_;
  RtsSmoother smoother_;
  std::vector<Matrix> whitening_;  ///< of Pˢ_k
};

}  // namespace credence::internal
