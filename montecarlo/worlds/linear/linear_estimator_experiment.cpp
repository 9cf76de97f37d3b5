#include "montecarlo/worlds/linear/linear_estimator_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/filters/linear_estimators.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/linear/linear_keys.h"
#include "montecarlo/worlds/linear/linear_world.h"
#include "montecarlo/worlds/linear/smoother_experiment.h"

namespace credence {

std::vector<std::string_view> linear_estimator_names(const Scenario* scenario) {
  std::vector<std::string_view> names = {"kalman", "steady-state", "smoother"};
  if (scenario == nullptr || !considered_states(*scenario).empty()) names.push_back("schmidt");
  if (scenario == nullptr || linear_gain(*scenario).size() > 0) names.push_back("own-gain");
  return names;
}

std::unique_ptr<Experiment> linear_estimator_experiment(const Scenario& scenario, std::string_view name) {
  LinearProblem problem = linear_world_problem(scenario);
  const Index steps = scenario.study.steps;
  const NoiseSource source(scenario.study.seed, noise_group(scenario));
  if (name == "kalman") return make_linear_experiment(std::move(problem), steps, source);
  if (problem.detection_probability < 1.0) {
    throw std::invalid_argument(
        fmt::format("filter.estimator = \"{}\" needs every measurement: noise.detection_probability is {:g}",
                    name, problem.detection_probability));
  }
  if (name == "smoother") return std::make_unique<SmootherExperiment>(std::move(problem), steps, source);
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

}  // namespace credence
