#pragma once

#include "core/filters/slam_phases.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence::internal {

/// An error farther than this from the truth, in m, is divergence.
inline constexpr double kDivergedError_m = 1e4;

/// What the statistics take of one step of one planar run.
struct PlanarStep {
  Outcome outcome = Outcome::ok;
  UpdateResult update;
  double nees = 0.0;          ///< eᵀ P⁻¹ e over the states of non-zero variance
  Index nees_dof = 0;         ///< how many these are
  double vehicle_nees = 0.0;  ///< of the pose block
  Index vehicle_dof = 3;
  PlanarTraces traces;
  double position_error_squared = 0.0, heading_error_squared = 0.0;
  double map_error_squared = 0.0;  ///< summed over the landmarks in the state
  Index landmarks = 0;             ///< how many these are

  void add_to(StepStatistics& s, RunTotals& sums) const;
};

}  // namespace credence::internal
