#include "montecarlo/worlds/linear/linear_world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/append_item.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/estimator_key.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/linear/linear_estimator_experiment.h"
#include "montecarlo/worlds/linear/linear_keys.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

constexpr Index kMostBlocks = 50;   // beyond them only the whole state is judged
constexpr Index kLargestWhole = 4;  // innovations up to this dimension are judged as one piece

Index columns_of(const Scenario& scenario, std::string_view path) {
  return std::ssize(rows_value(scenario, path).front());
}
Index states_of(const Scenario& scenario) { return columns_of(scenario, "world.F"); }
Index measurements_of(const Scenario& scenario) { return columns_of(scenario, "world.R"); }

BlockLayout linear_blocks(const Scenario& scenario) {
  return {.vehicle = states_of(scenario), .landmark = 0, .landmarks = 0};
}

void set_linear_defaults(Scenario& scenario) { set_estimator(scenario, "kalman"); }

bool is_kalman(const Scenario& scenario) { return word_value(scenario, "filter.estimator") == "kalman"; }

/// Nothing where the gain is not that of the Kalman filter, which alone has a Riccati equation.
std::optional<LinearProblem> linear_problem_of(const Scenario& scenario) {
  if (!is_kalman(scenario)) return std::nullopt;
  return linear_world_problem(scenario);
}

std::unique_ptr<Experiment> linear_experiment_of(const Scenario& scenario) {
  return linear_estimator_experiment(scenario, word_value(scenario, "filter.estimator"));
}

double least_linear_doubles(const Scenario& scenario) {
  return linear_problem_doubles(static_cast<double>(states_of(scenario)),
                                static_cast<double>(measurements_of(scenario)), scenario);
}

std::string linear_size_text(const Scenario& scenario) {
  const Index n = states_of(scenario);
  return fmt::format("world.F of {}×{}", n, n);
}

/// The matrices that the filter has of its own: ", a filter with its own F and Q".
std::string own_matrices_text(const Scenario& scenario) {
  std::vector<std::string> own;
  for (const char* name : {"F", "G", "H", "Q", "R", "P0"}) {
    if (!rows_value(scenario, fmt::format("filter.{}", name)).empty()) own.emplace_back(name);
  }
  return own.empty() ? "" : fmt::format(", a filter with its own {}", fmt::join(own, ", "));
}

std::string linear_text(const Scenario& scenario) {
  const Index n = states_of(scenario), m = measurements_of(scenario);
  const double seen = scenario.noise.detection_probability;
  const Index period = integer_value(scenario, "world.period");
  return fmt::format(
      "linear, {}, {}{}{}{}{}{}", counted(n, "state"), counted(m, "measurement"),
      period == 1 ? "" : fmt::format(", of period {}", period),
      seen < 1.0 ? fmt::format(", each there with probability {:g}", seen) : "",
      noise_switches_text(scenario), own_matrices_text(scenario),
      is_kalman(scenario) ? "" : fmt::format(", {}", word_value(scenario, "filter.estimator")));
}

/// Of a piece of the measurement. Where some may be missing only what all have in common.
std::vector<double> assumed_variances(const Matrix& R, bool constant) {
  if (!R.isDiagonal(0.0)) return {};
  const Vector variances = R.diagonal();
  if (constant) return {variances.begin(), variances.end()};
  if ((variances.array() == variances[0]).all()) return {variances[0]};
  return {};
}

}  // namespace

LinearProblem linear_world_problem(const Scenario& scenario) {
  LinearProblem problem;
  std::vector<LinearModel> truth = linear_truth(scenario), assumed = linear_belief(scenario);
  for (LinearModel& model : assumed) {
    model.Q *= scenario.filter.process_scale;
    model.R *= scenario.filter.measurement_scale;
  }
  problem.truth = truth.front();
  problem.assumed = assumed.front();
  problem.truth_later.assign(truth.begin() + 1, truth.end());
  problem.assumed_later.assign(assumed.begin() + 1, assumed.end());
  problem.detection_probability = scenario.noise.detection_probability;
  problem.measurement_delay = measurement_delay(scenario);
  const bool constant = problem.detection_probability == 1.0;
  problem.scene = {.layout = linear_layout(linear_state_names(scenario), problem.assumed.R, constant),
                   .start = Vector::Zero(problem.truth.state_dim()),
                   .random_start = true};
  // Of a noise that changes with the steps no single variance can be told.
  const auto same_R = [&](const LinearModel& model) { return model.R == problem.assumed.R; };
  if (!std::ranges::all_of(assumed, same_R)) problem.scene.layout.sensors.front().variances.clear();
  return problem;
}

RunLayout linear_layout(std::vector<std::string> states, const Matrix& R, bool constant) {
  const Index m = R.rows();
  RunLayout layout;
  layout.states = std::move(states);
  layout.angles.assign(layout.states.size(), false);
  add_named_blocks(layout);
  if (layout.blocks.size() == 1 || std::ssize(layout.blocks) > kMostBlocks) layout.blocks.clear();
  layout.sensors = {{.name = "",
                     .dim = m,
                     .piece = constant && m <= kLargestWhole ? m : 1,
                     .variances = assumed_variances(R, constant)}};
  return layout;
}

constinit const World kLinearWorld = {.schema = {.name = "linear",
                                                 .meaning = "any linear system, its matrices written out",
                                                 .keys = linear_keys,
                                                 .set_defaults = set_linear_defaults,
                                                 .check = check_linear,
                                                 .blocks = linear_blocks},
                                      .linear_problem = linear_problem_of,
                                      .experiment = linear_experiment_of,
                                      .least_doubles = least_linear_doubles,
                                      .size_text = linear_size_text,
                                      .text = linear_text,
                                      .figure = RunFigure::states,
                                      .estimators = &kLinearOffer};

}  // namespace credence::internal
