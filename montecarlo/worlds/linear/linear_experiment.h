#pragma once

#include "core/filters/linear_filter.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/lanes/linear_kernel.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/linear/linear_problem.h"

namespace credence::internal {

/// Many runs of one linear filter. Its covariances and gains depend on no data and are computed once; a run
/// is the propagation of its error alone (theory, section 3).
class LinearExperiment final : public Experiment {
 public:
  /// `truth` of the problem makes the noise, `assumed` is what the filter believes; every measurement is
  /// there at every step.
  LinearExperiment(const LinearProblem& problem, Index steps, NoiseSource source);
  /// Of a filter with other gains than the Kalman filter's.
  LinearExperiment(LinearProblem problem, Index steps, NoiseSource source,
                   std::vector<LinearFilterStep> filter_steps);

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override;
  Outcome visit(std::int64_t run, const StepVisitor& take) const override;

  /// Of the steps of a period; a single one where the same model holds at all steps.
  const std::vector<LinearModel>& true_models() const { return truth_; }
  const std::vector<LinearModel>& assumed_models() const { return assumed_; }

  /// Shorter than the study if S was not positive definite at some step.
  const std::vector<LinearFilterStep>& filter_steps() const { return filter_steps_; }

  RunTrace describe_world() const override;

 private:
  LinearProblem problem_;
  Index steps_;
  NoiseSource source_;
  std::vector<LinearModel> truth_, assumed_;
  std::vector<LinearFilterStep> filter_steps_;
  LinearErrorSystem system_;
  LinearSimulator simulator_;
};

/// Whether every run has a filter of its own: measurements are missed or late, or noise is not white and
/// Gaussian.
bool plays_every_run_by_itself(double detection_probability, Index measurement_delay,
                               const NoiseSource& source);

/// The experiment of a linear problem: a LinearExperiment, or an IntermittentExperiment, which plays every
/// run by itself.
std::unique_ptr<Experiment> make_linear_experiment(LinearProblem problem, Index steps, NoiseSource source);

}  // namespace credence::internal
