#pragma once

#include "datasets/replay/mrclam.h"
#include "datasets/replay/replay_result.h"

namespace credence::internal {

/// Unicycle EKF-SLAM on the log of one MRCLAM robot, judged by motion capture: pose NEES of 3 dof.
///
/// Starts at the true pose at the first odometry sample that has one; observations before that are counted,
/// not used. Odometry holds between its samples, for kMrclamMaxHoldS at most, then the robot is taken to
/// stand. Predictions are at most 20 ms apart. The pose is compared after the observations of each time.
/// Throws std::invalid_argument for impossible settings and DataError when the motion capture never has a
/// pose while the odometry speaks.
ReplayResult replay_mrclam(const MrclamLog& log, const ReplaySettings& settings);

inline constexpr double kMrclamMaxHoldS = 1.5;

}  // namespace credence::internal
