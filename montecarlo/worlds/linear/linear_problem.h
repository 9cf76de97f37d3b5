#pragma once

#include "core/record/run_layout.h"
#include "core/types.h"
#include "montecarlo/lanes/intermittent_lanes.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// What the runs of a linear world show beside their errors.
struct LinearScene {
  RunLayout layout;
  Vector start;               ///< x_0, n
  bool random_start = false;  ///< true: x̂_0 is `start`, and x_0 = x̂_0 + e_0; false: x_0 is `start`
  Matrix landmark_positions{}, anchor_positions{};  ///< d×N and d×anchors; empty in worlds without a map
};

/// A linear world, the filter in it, and how its runs are shown. Where the filter has another F or H than the
/// world, the scene must start at 0 with a random start: then x̂ is no function of e alone.
struct LinearProblem : IntermittentProblem {
  LinearScene scene;
};

/// Doubles that its experiment keeps with n states and m measurements: dense models of truth and filter (F
/// and P0, H, R), and of the filter's steps P before and after the update, ΔP, K and S. Where measurements
/// are missed or late, or noise is not white and Gaussian, every run has steps of its own, of which none is
/// kept.
double linear_problem_doubles(double n, double m, const Scenario& scenario);

/// Throws ScenarioError where the states of an unstable world grow so large within these steps that
/// differences of them, which smoothing and scores are made of, have lost 1e-4 of a σ of its measurements.
void require_exact_differences(const LinearProblem& problem, Index steps);

}  // namespace credence::internal
