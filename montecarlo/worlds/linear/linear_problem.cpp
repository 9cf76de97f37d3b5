#include "montecarlo/worlds/linear/linear_problem.h"

namespace credence::internal {

double linear_problem_doubles(double n, double m, const Scenario& scenario) {
  const double steps =
      scenario.noise.detection_probability < 1.0 ? 1.0 : static_cast<double>(scenario.study.steps);
  return 2.0 * (2.0 * n * n + n * m + m * m) + steps * (3.0 * n * n + n * m + m * m);
}

}  // namespace credence::internal
