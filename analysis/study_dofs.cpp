#include "analysis/study_dofs.h"

#include <stdexcept>

namespace credence {

std::vector<double> study_dofs(const StudyStatistics& statistics, Quantity quantity) {
  if (quantity != Quantity::nees && quantity != Quantity::nis) {
    throw std::invalid_argument("only the dof of NEES and NIS are counted");
  }
  std::vector<double> result;
  result.reserve(statistics.steps.size());
  for (const StepStatistics& step : statistics.steps) {
    result.push_back(static_cast<double>(quantity == Quantity::nees ? step.nees_dof : step.nis_dof));
  }
  return result;
}

}  // namespace credence
