#include "montecarlo/worlds/linear/linear_problem.h"

#include "montecarlo/scenario/noise_switches.h"

namespace credence::internal {
namespace {

/// As make_linear_experiment decides.
bool plays_every_run_by_itself(const Scenario& scenario) {
  return scenario.noise.detection_probability < 1.0 || measurement_delay(scenario) > 0 ||
         !noise_source(scenario).is_plain();
}

}  // namespace

double linear_problem_doubles(double n, double m, const Scenario& scenario) {
  const double steps = plays_every_run_by_itself(scenario) ? 1.0 : static_cast<double>(scenario.study.steps);
  return 2.0 * (2.0 * n * n + n * m + m * m) + steps * (3.0 * n * n + n * m + m * m);
}

}  // namespace credence::internal
