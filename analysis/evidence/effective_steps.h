#pragma once

#include <span>
#include <vector>

namespace credence {

/// Independent steps that the NEES of a run is worth, measured on the NEES of whole runs, one series for each
/// (empirical_nees_time_law). Throws std::invalid_argument for fewer than two runs and for runs of different
/// lengths.
double measured_effective_steps(std::span<const std::vector<double>> runs);

}  // namespace credence
