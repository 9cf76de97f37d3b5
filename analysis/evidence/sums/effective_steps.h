#pragma once

#include <span>
#include <vector>

namespace credence::internal {

/// Independent steps that the NEES of a run is worth, T Σ_k Var ε_k / Var Σ_k ε_k, measured on the NEES of
/// whole runs, one series for each. Cost and memory are linear in runs and steps. Throws
/// std::invalid_argument for fewer than two runs and for runs of different lengths.
double measured_effective_steps(std::span<const std::vector<double>> runs);

}  // namespace credence::internal
