#include "montecarlo/worlds/linear/linear_estimator_experiment.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/filters/linear_estimators.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_keys.h"
#include "montecarlo/worlds/linear/linear_world.h"
#include "montecarlo/worlds/linear/smoother_experiment.h"

namespace credence::internal {
namespace {

/// Gains that depend on no data are computed for one model, every measurement and the noise believed.
void require_plain(const LinearProblem& problem, const NoiseSource& source, std::string_view name) {
  const auto refuse = [&](std::string_view why) {
    throw std::invalid_argument(fmt::format("filter.estimator = \"{}\" {}", name, why));
  };
  if (problem.detection_probability < 1.0) {
    refuse(fmt::format("needs every measurement: noise.detection_probability is {:g}",
                       problem.detection_probability));
  }
  if (problem.measurement_delay > 0) refuse("needs every measurement in time: noise.measurement_delay");
  if (!source.is_plain()) refuse("needs noise that is white and Gaussian; \"kalman\" takes any");
  if (problem.is_periodic()) refuse("needs matrices that are the same at all steps: world.period must be 1");
}

}  // namespace

std::vector<std::string_view> linear_estimator_names(const Scenario* scenario) {
  std::vector<std::string_view> names = {"kalman", "steady-state", "smoother"};
  if (scenario == nullptr || !considered_states(*scenario).empty()) names.push_back("schmidt");
  if (scenario == nullptr || linear_gain(*scenario).size() > 0) names.push_back("own-gain");
  return names;
}

std::unique_ptr<Experiment> linear_estimator_experiment(const Scenario& scenario, std::string_view name) {
  LinearProblem problem = linear_world_problem(scenario);
  const Index steps = scenario.study.steps;
  const NoiseSource source = noise_source(scenario);
  if (name == "kalman") return make_linear_experiment(std::move(problem), steps, source);
  require_plain(problem, source, name);
  if (name == "smoother") return std::make_unique<SmootherExperiment>(problem, steps, source);
  const LinearModel& assumed = problem.assumed;
  std::vector<LinearFilterStep> of_filter;
  if (name == "steady-state") {
    of_filter = constant_gain_steps(assumed, steady_state_gain(assumed), steps);
  } else if (name == "schmidt") {
    const std::vector<Index> considered = considered_states(scenario);
    if (considered.empty()) {
      throw std::invalid_argument("filter.estimator = \"schmidt\" needs filter.considered");
    }
    of_filter = consider_steps(assumed, considered, steps);
  } else {
    const Matrix K = linear_gain(scenario);
    if (K.size() == 0) throw std::invalid_argument("filter.estimator = \"own-gain\" needs filter.gain");
    of_filter = constant_gain_steps(assumed, K, steps);
  }
  return std::make_unique<LinearExperiment>(std::move(problem), steps, source, std::move(of_filter));
}

}  // namespace credence::internal
