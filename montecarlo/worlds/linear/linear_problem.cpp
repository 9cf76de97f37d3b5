#include "montecarlo/worlds/linear/linear_problem.h"

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_experiment.h"

namespace credence::internal {

double linear_problem_doubles(double n, double m, const Scenario& scenario) {
  const bool by_itself = plays_every_run_by_itself(scenario.noise.detection_probability,
                                                   measurement_delay(scenario), noise_source(scenario));
  const double steps = by_itself ? 1.0 : static_cast<double>(scenario.study.steps);
  return 2.0 * (2.0 * n * n + n * m + m * m) + steps * (3.0 * n * n + n * m + m * m);
}

}  // namespace credence::internal
