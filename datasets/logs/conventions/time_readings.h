#pragma once

#include <functional>
#include <span>
#include <vector>

#include "datasets/logs/conventions/pose_readings.h"

namespace credence::internal {

/// The truth at a time; false where there is none.
using TruthLookup = std::function<bool(double time_s, SpatialPose& truth)>;

/// Times of the estimate that are off, as a reading: of samples with the truth at the times that were meant.
struct TimeReading {
  PoseReading reading;
  std::vector<PoseSample> samples;  ///< those that have a truth there
};

/// Times one sample too early or too late, and those for which the mean NEES is least (time_of_least_cost)
/// where it takes at least a tenth of it away; each where at least half of the samples have a truth there.
/// `spacing_s`: the time between two estimates.
std::vector<TimeReading> time_readings(const PoseChart& declared, std::span<const PoseSample> samples,
                                       double spacing_s, const TruthLookup& truth_at);

}  // namespace credence::internal
