#include "montecarlo/worlds/linear/linear_experiment.h"

#include <algorithm>
#include <limits>
#include <span>

#include "core/linear_algebra/psd_root.h"
#include "core/models/model_mismatch.h"
#include "montecarlo/worlds/linear/intermittent_experiment.h"
#include "montecarlo/worlds/linear/linear_trace.h"

namespace credence::internal {
namespace {

/// L with L n the error at the start; where the state of the model holds x beside e, both are that error.
Matrix initial_root(const LinearModel& truth, Index states) {
  Matrix root = psd_root(truth.P0);
  const Index n = root.rows();
  if (states == n) return root;
  Matrix both = Matrix::Zero(states, states);
  both.topLeftCorner(n, n) = root;
  both.bottomLeftCorner(n, n) = root;
  return both;
}

LinearErrorDynamics dynamics_of(const LinearModel& model) {
  return {.F = model.F,
          .noise_input = model.G * psd_root(model.Q),
          .H = model.H,
          .measurement_root = psd_root(model.R)};
}

LinearErrorSystem make_error_system(const std::vector<LinearModel>& truth,
                                    const std::vector<LinearModel>& assumed,
                                    const std::vector<LinearFilterStep>& steps) {
  const std::vector<LinearModel> models = error_models(truth, assumed);
  const Index states = models.front().state_dim();
  LinearErrorSystem system{dynamics_of(models.front()), initial_root(truth.front(), states), {}, {}};
  for (std::size_t phase = 1; phase < models.size(); ++phase) {
    system.later.push_back(dynamics_of(models[phase]));
  }
  for (const LinearFilterStep& step : steps) {
    if (!step.ok || !(step.P_prior.trace() < kLargestTrace)) break;
    const Matrix whitening = psd_whitening(step.P, step.P_prior.diagonal());
    system.steps.push_back({.K = padded(step.K, states, step.K.cols()),
                            .innovation_whitening = psd_whitening(step.S),
                            .error_whitening = padded(whitening, whitening.rows(), states)});
  }
  return system;
}

}  // namespace

LinearExperiment::LinearExperiment(const LinearProblem& problem, Index steps, NoiseSource source)
    : LinearExperiment(problem, steps, source,
                       linear_filter_steps(problem.assumed_period(), problem.rule, steps)) {}

LinearExperiment::LinearExperiment(LinearProblem problem, Index steps, NoiseSource source,
                                   std::vector<LinearFilterStep> filter_steps)
    : Experiment(problem.scene.layout),
      problem_(std::move(problem)),
      steps_(steps),
      source_(source),
      truth_(problem_.truth_period()),
      assumed_(problem_.assumed_period()),
      filter_steps_(std::move(filter_steps)),
      system_(make_error_system(truth_, assumed_, filter_steps_)),
      simulator_(system_) {}

StudyStatistics LinearExperiment::run_chunk(std::int64_t first_run, std::int64_t runs) const {
  const std::size_t good_steps = system_.steps.size();
  std::vector<Moments> nees(good_steps), nis(good_steps);
  std::vector<double> of_runs(static_cast<std::size_t>(runs));
  simulator_.simulate(source_, first_run, runs, nees, nis, of_runs);

  StudyStatistics statistics;
  statistics.runs = runs;
  statistics.steps.resize(static_cast<std::size_t>(steps_));
  for (std::size_t k = 0; k < good_steps; ++k) {
    StepStatistics& s = statistics.steps[k];
    s[Quantity::nees] = nees[k];
    s[Quantity::nis] = nis[k];
    s.nees_dof = runs * system_.steps[k].error_whitening.rows();
    s.nis_dof = runs * system_.steps[k].innovation_whitening.rows();
  }
  const auto not_converged =
      std::ranges::count(std::span(filter_steps_).first(good_steps), false, &LinearFilterStep::converged);
  for (std::int64_t r = first_run; not_converged > 0 && r < first_run + runs; ++r) {
    statistics.not_converged.push_back({r, not_converged});
  }
  if (good_steps == statistics.steps.size()) {
    std::int64_t dof = 0, least = std::numeric_limits<std::int64_t>::max();
    for (const LinearErrorSystem::Step& step : system_.steps) {
      dof += step.error_whitening.rows();
      if (step.error_whitening.rows() > 0) least = std::min<std::int64_t>(least, step.error_whitening.rows());
    }
    for (const double sum : of_runs) statistics.nees_of_runs.add(sum, static_cast<double>(dof), least);
  } else {
    for (std::int64_t r = first_run; r < first_run + runs; ++r) {
      statistics.failures.push_back(
          {r, static_cast<std::int64_t>(good_steps) + 1, Outcome::not_positive_definite});
    }
  }
  return statistics;
}

RunTrace LinearExperiment::describe_world() const { return describe_scene(problem_.scene); }

Outcome LinearExperiment::visit(std::int64_t run, const StepVisitor& take) const {
  const Index n = problem_.truth.state_dim();
  const LinearRunTrace errors = trace_linear(system_, source_, run);
  TraceStep now;
  name_states(problem_.truth.layout, now);
  Vector x = linear_start(problem_.scene, errors.initial_error.head(n));
  set_error(x, errors.initial_error.head(n), now);
  now.P = problem_.assumed.P0;
  take(now);
  for (std::size_t k = 0; k < system_.steps.size(); ++k) {
    const LinearFilterStep& filter = filter_steps_[k];
    const LinearModel& truth = model_at(truth_, static_cast<Index>(k) + 1);
    x = truth.F * x + errors.process_noise[k].head(n);
    now.step = static_cast<std::int64_t>(k) + 1;
    set_error(x, errors.errors[k].head(n), now);
    now.P = filter.P;
    now.innovations.front() = {errors.innovations[k], filter.S};
    now.K = filter.K;
    now.z = truth.H * x + errors.measurement_noise[k];
    now.nees = errors.nees[k];
    now.nis = errors.nis[k];
    now.nees_dof = system_.steps[k].error_whitening.rows();
    now.nis_dof = system_.steps[k].innovation_whitening.rows();
    take(now);
  }
  const Index good_steps = std::ssize(system_.steps);
  if (good_steps == steps_) return Outcome::ok;
  take(shown_at(good_steps + 1, Outcome::not_positive_definite, now));
  return Outcome::not_positive_definite;
}

bool plays_every_run_by_itself(double detection_probability, Index measurement_delay,
                               const NoiseSource& source) {
  return detection_probability < 1.0 || measurement_delay > 0 || !source.is_plain();
}

std::unique_ptr<Experiment> make_linear_experiment(LinearProblem problem, Index steps, NoiseSource source) {
  if (plays_every_run_by_itself(problem.detection_probability, problem.measurement_delay, source)) {
    return std::make_unique<IntermittentExperiment>(std::move(problem), steps, source);
  }
  return std::make_unique<LinearExperiment>(problem, steps, source);
}

}  // namespace credence::internal
