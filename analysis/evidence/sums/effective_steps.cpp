#include "analysis/evidence/sums/effective_steps.h"

#include <fmt/format.h>

#include <stdexcept>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

double measured_effective_steps(std::span<const std::vector<double>> runs) {
  if (runs.size() < 2) {
    throw std::invalid_argument(fmt::format("NEES of {} runs: at least 2 are needed", runs.size()));
  }
  const std::size_t steps = runs.front().size();
  std::vector<Moments> at(steps);
  Moments of_sums;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs[r].size() != steps) {
      throw std::invalid_argument(
          fmt::format("NEES of run {}: {} steps where the first has {}", r, runs[r].size(), steps));
    }
    double sum = 0.0;
    for (std::size_t k = 0; k < steps; ++k) {
      at[k].add(runs[r][k]);
      sum += runs[r][k];
    }
    of_sums.add(sum);
  }
  double independent = 0.0;
  for (const Moments& step : at) independent += step.variance();
  return static_cast<double>(steps) * independent / of_sums.variance();
}

}  // namespace credence::internal
