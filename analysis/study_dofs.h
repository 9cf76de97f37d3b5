#pragma once

#include <vector>

#include "montecarlo/study_statistics.h"

namespace credence {

/// The dof of NEES or NIS at every step, summed over the runs, as the judges want them beside series();
/// std::invalid_argument for another quantity.
std::vector<double> study_dofs(const StudyStatistics& statistics, Quantity quantity);

}  // namespace credence
