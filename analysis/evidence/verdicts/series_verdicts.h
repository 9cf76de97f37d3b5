#pragma once

#include <cstddef>
#include <vector>

#include "analysis/evidence/sums/evidence.h"
#include "analysis/evidence/verdicts/consistency.h"

/// @file
/// Verdicts on what the evidence has of every step.

namespace credence::internal {

/// Moments and dof of every step, as the judges want them.
struct StepSeries {
  std::vector<Moments> moments;
  std::vector<double> dof;
};

StepSeries series_of(const SumsOverSteps& sums, std::size_t steps);

/// The verdict on the NEES of the whole state.
ConsistencyVerdict judge_state(const Evidence& evidence, const StepSeries& nees, double confidence,
                               const RunAverages* runs = nullptr);

/// The verdict on the NIS of all sensors. Those of one step may have been taken against the same prior, whose
/// error they then share.
ConsistencyVerdict judge_all_sensors(const Evidence& evidence, const StepSeries& nis, double confidence);

}  // namespace credence::internal
