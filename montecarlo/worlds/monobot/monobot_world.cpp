#include "montecarlo/worlds/monobot/monobot_world.h"

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/slam_layout.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

std::vector<KeyRow> monobot_keys() {
  using N = NoiseSettings;
  constexpr auto kNoise = &Scenario::noise;
  std::vector<KeyRow> keys = slam_keys();
  keys.insert(keys.end(),
              {{"noise", "process_variance", "m^2", "Q, variance of the vehicle's motion in one step",
                real_field<kNoise, &N::process_variance>(Interval::kNotNegative)},
               {"noise", "measurement_variance", "m^2", "R, variance of each measurement",
                real_field<kNoise, &N::measurement_variance>(Interval::kNotNegative)},
               {"noise", "initial_variance", "m^2", "variance of every state at the start",
                real_field<kNoise, &N::initial_variance>(Interval::kNotNegative)}});
  return keys;
}

void check_monobot(const Scenario& scenario, const Refusal& refuse) {
  check_landmarks(scenario, refuse);
  check_inflation(scenario, refuse);
}

BlockLayout monobot_blocks(const Scenario& scenario) {
  return {.vehicle = 1, .landmark = 1, .landmarks = scenario.world.landmarks};
}

double least_monobot_doubles(const Scenario& scenario) {
  const auto n = static_cast<double>(monobot_blocks(scenario).state_dim());
  const auto m = static_cast<double>(scenario.world.landmarks + scenario.world.anchors);
  return linear_problem_doubles(n, m, scenario);
}

/// Around +1 m, half a metre apart.
Vector monobot_start(const BlockLayout& layout) {
  Vector x = Vector::Constant(layout.state_dim(), 1.0);
  x[0] = -1.0;
  for (Index i = 0; i < layout.landmarks; ++i) {
    x[1 + i] += 0.5 * (static_cast<double>(i) - 0.5 * static_cast<double>(layout.landmarks - 1));
  }
  return x;
}

}  // namespace

LinearScene monobot_scene(const LinearModel& model, bool constant) {
  const BlockLayout& layout = model.layout;
  const Vector x = monobot_start(layout);
  return {.layout = slam_layout(layout, model.measurement_dim(), constant),
          .start = x,
          .random_start = false,
          .landmark_positions = x.tail(layout.landmarks).transpose(),
          .anchor_positions = Matrix::Zero(1, model.measurement_dim() - layout.landmarks)};
}

LinearProblem monobot_problem(const Scenario& scenario) {
  const NoiseSettings& noise = scenario.noise;
  LinearProblem problem;
  problem.truth = monobot_model(scenario.world.landmarks, scenario.world.anchors, noise.process_variance,
                                noise.measurement_variance, noise.initial_variance);
  problem.assumed = problem.truth;
  problem.assumed.Q *= scenario.filter.process_scale;
  problem.assumed.R *= scenario.filter.measurement_scale;
  problem.rule = make_inflation_rule(scenario);
  problem.detection_probability = noise.detection_probability;
  problem.measurement_delay = measurement_delay(scenario);
  problem.scene = monobot_scene(problem.truth, noise.detection_probability == 1.0);
  problem.scene.layout.sensors.front().variances = {problem.assumed.R(0, 0)};
  return problem;
}

constinit const World kMonobotWorld = {
    .schema = {.name = "monobot",
               .meaning = "vehicle on a line (linear)",
               .keys = monobot_keys,
               .check = check_monobot,
               .blocks = monobot_blocks},
    .linear_problem = [](const Scenario& s) { return std::optional(monobot_problem(s)); },
    .least_doubles = least_monobot_doubles,
    .size_text = slam_size_text,
    .text = slam_text,
    .figure = RunFigure::line_slam};

}  // namespace credence::internal
