#include "montecarlo/worlds/monobot/linear_experiment.h"

#include <algorithm>
#include <limits>

#include "core/linear_algebra/psd_root.h"
#include "montecarlo/worlds/monobot/linear_world.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence {
namespace {

LinearErrorSystem make_error_system(const LinearModel& truth, const std::vector<LinearFilterStep>& steps) {
  LinearErrorSystem system;
  system.F = truth.F;
  system.H = truth.H;
  system.noise_input = truth.G * psd_root(truth.Q);
  system.measurement_root = psd_root(truth.R);
  system.initial_root = psd_root(truth.P0);
  for (const LinearFilterStep& step : steps) {
    if (!step.ok) break;
    system.steps.push_back({.K = step.K,
                            .innovation_whitening = psd_whitening(step.S),
                            .error_whitening = psd_whitening(step.P)});
  }
  return system;
}

}  // namespace

LinearExperiment::LinearExperiment(LinearModel truth, const LinearModel& assumed, const InflationRule& rule,
                                   Index steps, NoiseSource source)
    : Experiment(slam_layout(truth.layout, truth.measurement_dim(), true)),
      truth_(std::move(truth)),
      steps_(steps),
      source_(source),
      filter_steps_(linear_filter_steps(assumed, rule, steps)),
      system_(make_error_system(truth_, filter_steps_)),
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

RunTrace LinearExperiment::describe_world() const { return describe_linear_world(truth_); }

Outcome LinearExperiment::visit(std::int64_t run, const StepVisitor& take) const {
  const LinearRunTrace errors = trace_linear(system_, source_, run);
  const std::vector<int> landmarks = linear_landmarks(truth_.layout);
  Vector x = linear_start(truth_.layout);
  TraceStep now;
  slam_states(truth_.layout, landmarks, now.states);
  now.landmarks = landmarks;
  now.truth = x;
  now.error = -errors.initial_error;
  now.estimate = x - errors.initial_error;
  now.P = truth_.P0;
  take(now);
  for (std::size_t k = 0; k < system_.steps.size(); ++k) {
    const LinearFilterStep& filter = filter_steps_[k];
    x = truth_.F * x + errors.process_noise[k];
    now.step = static_cast<std::int64_t>(k) + 1;
    now.truth = x;
    now.error = -errors.errors[k];
    now.estimate = x - errors.errors[k];
    now.P = filter.P;
    now.innovations.front() = {errors.innovations[k], filter.S};
    now.K = filter.K;
    now.z = truth_.H * x + errors.measurement_noise[k];
    now.nees = errors.nees[k];
    now.nis = errors.nis[k];
    now.nees_dof = system_.steps[k].error_whitening.rows();
    now.nis_dof = system_.steps[k].innovation_whitening.rows();
    take(now);
  }
  return system_.steps.size() < static_cast<std::size_t>(steps_) ? Outcome::not_positive_definite
                                                                 : Outcome::ok;
}

}  // namespace credence
