#pragma once

#include <string>

#include "datasets/replay/mrclam.h"

namespace credence::internal {

/// Whether the truth moves where it heads: the mean cosine between course and heading over second-long steps
/// must exceed ½. Swapped or mirrored coordinates fail this. Returns the problem, or an empty string.
std::string truth_contradiction(const MrclamLog& log);

/// Whether the odometry drives as far as the truth, within a factor of two. Swapped columns fail this.
std::string odometry_contradiction(const MrclamLog& log);

/// Whether the measured ranges and bearings fit the truth and the survey: half of them or more must lie
/// within 0.5 m and 10°. The wrong robot's file and a wrong table of barcodes fail this.
std::string measurement_contradiction(const MrclamLog& log);

}  // namespace credence::internal
