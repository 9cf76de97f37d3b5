#include "montecarlo/worlds/linear/linear_problem.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_experiment.h"

namespace credence::internal {

double linear_problem_doubles(double n, double m, const Scenario& scenario) {
  const bool by_itself = plays_every_run_by_itself(scenario.noise.detection_probability,
                                                   measurement_delay(scenario), noise_source(scenario));
  const double steps = by_itself ? 1.0 : static_cast<double>(scenario.study.steps);
  return 2.0 * (2.0 * n * n + n * m + m * m) + steps * (3.0 * n * n + n * m + m * m);
}

void require_exact_differences(const LinearProblem& problem, Index steps) {
  constexpr double kMostLost = 1e-4;
  const std::vector<LinearModel> period = problem.truth_period();
  const Index n = problem.truth.state_dim();
  // Two paths whose noise is one σ at every step, of one sign and of signs in turn over the states.
  Matrix paths(n, 2);
  for (Index i = 0; i < n; ++i) {
    paths(i, 0) = std::abs(problem.scene.start[i]) + std::sqrt(problem.truth.P0(i, i));
    paths(i, 1) = i % 2 == 0 ? paths(i, 0) : -paths(i, 0);
  }
  for (Index k = 0; k < steps; ++k) {
    const LinearModel& model = period[static_cast<std::size_t>(k) % period.size()];
    if (!problem.is_periodic() && model.F.isIdentity(0.0)) return;  // grows by its noise alone
    paths = (model.F * paths).colwise() + Vector(model.G * model.Q.diagonal().cwiseSqrt());
    const Vector seen = (model.H * paths).cwiseAbs().rowwise().maxCoeff();
    const Vector lost = seen * std::numeric_limits<double>::epsilon(), sigma = model.R.diagonal().cwiseSqrt();
    if ((sigma.array() == 0.0 || lost.array() <= kMostLost * sigma.array()).all()) continue;
    throw ScenarioError(fmt::format(
        "study.steps = {}: this world is unstable, and from step {} on its states are so large that the "
        "difference of two has lost what measurements tell; a smoother and tune take fewer steps",
        steps, k + 1));
  }
}

}  // namespace credence::internal
