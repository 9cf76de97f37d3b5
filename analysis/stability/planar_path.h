#pragma once

#include <vector>

#include "analysis/stability/planar_stability.h"
#include "montecarlo/worlds/planar/planar_world.h"

/// @file
/// EKF-SLAM driven round and round its nominal path, with everything kept that stability is judged by.

namespace credence::internal {

/// One loop of a filter, the last: Jacobians, noise and gains at every step, in the state of its end.
struct PlanarLoopRecord {
  BlockLayout layout;
  Vector start;                   ///< estimate at the beginning of the loop
  std::vector<Matrix> F;          ///< F_k, n×n, of steps 1 … T
  std::vector<Matrix> H;          ///< one more than F: none before the first step, then what each step saw
  std::vector<Matrix> K;          ///< gains, n×rows of H
  std::vector<Matrix> process;    ///< G Q Gᵀ of each step
  std::vector<Matrix> inflation;  ///< ΔP before the update of each step; zero for a sequential rule
};

/// A filter followed along its path.
struct PlanarPathRun {
  PlanarWorld world;
  bool ok = true;              ///< false: S lost positive definiteness, or the estimate diverged
  Index failed_at = 0;         ///< at this step
  std::vector<double> traces;  ///< mean of tr P over each loop
  Index not_converged = 0;     ///< steps whose exact minimal trace missed its tolerance
  double pose_nees = 0.0;      ///< over its dof, mean over the last half; NaN at the truth, and if it failed
  PlanarLoopRecord loop;       ///< empty where not all landmarks were known when it began, and if it failed
};

/// Steps once round the path, rounded up. Throws std::invalid_argument naming the keys where they are none or
/// more than 10^7.
Index planar_steps_per_loop(const Scenario& scenario);

/// Drives the filter of the scenario for so many loops; without noise at the truth, else with that of run 0.
/// Throws std::invalid_argument where there is not enough memory for that.
PlanarPathRun follow_planar_path(const Scenario& scenario, Index loops, Linearisation at);

}  // namespace credence::internal
