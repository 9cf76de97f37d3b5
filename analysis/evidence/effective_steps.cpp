#include "analysis/evidence/effective_steps.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/laws/effective_sample.h"

namespace credence {

double measured_effective_steps(std::span<const std::vector<double>> runs) {
  const std::size_t steps = runs.empty() ? 0 : runs.front().size();
  Matrix nees(static_cast<Index>(runs.size()), static_cast<Index>(steps));
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs[r].size() != steps) {
      throw std::invalid_argument(
          fmt::format("NEES of run {}: {} steps where the first has {}", r, runs[r].size(), steps));
    }
    nees.row(static_cast<Index>(r)) = Eigen::Map<const Eigen::RowVectorXd>(runs[r].data(), nees.cols());
  }
  return empirical_nees_time_law(nees).effective_steps;
}

}  // namespace credence
