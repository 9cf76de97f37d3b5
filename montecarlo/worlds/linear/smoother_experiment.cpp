#include "montecarlo/worlds/linear/smoother_experiment.h"

#include "core/linear_algebra/psd_root.h"
#include "core/stop_point.h"

namespace credence::internal {

SmootherExperiment::SmootherExperiment(const LinearProblem& problem, Index steps, NoiseSource source)
    : VisitedExperiment(problem.scene.layout, steps),
      filter_(problem, steps, source),
      smoother_(filter_.assumed_models().front(), filter_.filter_steps()) {
  require_exact_differences(problem, steps);
  const std::vector<LinearFilterStep>& of_filter = filter_.filter_steps();
  whitening_.push_back(psd_whitening(smoother_.covariance(0)));
  for (std::size_t k = 0; k < of_filter.size(); ++k) {
    whitening_.push_back(psd_whitening(smoother_.covariance(k + 1), of_filter[k].P_prior.diagonal()));
  }
}

Outcome SmootherExperiment::visit(std::int64_t run, const StepVisitor& take) const {
  std::vector<TraceStep> steps;
  const Outcome outcome = filter_.visit(run, [&](const TraceStep& step) {
    stop_point();
    steps.push_back(step);
  });
  std::vector<Vector> estimates;
  estimates.reserve(steps.size());
  for (const TraceStep& step : steps) estimates.push_back(step.estimate);
  smoother_.smooth(estimates);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    TraceStep& step = steps[k];
    step.estimate = estimates[k];
    step.error = step.estimate - step.truth;
    step.P = smoother_.covariance(k);
    step.innovations.front() = {};
    step.K.resize(0, 0);
    step.nis = 0.0;
    step.nis_dof = 0;
    step.nees = (whitening_[k] * step.error).squaredNorm();
    step.nees_dof = whitening_[k].rows();
    take(step);
  }
  return outcome;
}

}  // namespace credence::internal
