#pragma once

#include <vector>

#include "montecarlo/lanes/linear_kernel.h"

/// @file
/// Units in which a linear run is cheap: most of its time is multiplications, and these are saved. Internal.

namespace credence::internal {

/// A LinearErrorSystem with errors, innovations and noise divided by `unit`, the first entry of noise_input
/// that is not zero, and whitenings whose last entry is one: W' = W unit/c, so that NIS = c² ‖W' nu'‖², and
/// so for NEES.
struct LinearSystemInUnits {
  LinearErrorSystem system;
  double unit = 1.0;
  std::vector<double> nis_scale, nees_scale;  ///< c² of each step
};

/// Throws as check_linear_error_system does.
LinearSystemInUnits linear_system_in_units(const LinearErrorSystem& system);

}  // namespace credence::internal
