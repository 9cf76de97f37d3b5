#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/logs/trajectory.h"

/// @file
/// From a trajectory and its truth to errors that can be judged.

namespace credence {

/// How the truth at the time of an estimate is found.
enum class TruthTime {
  interpolated,  ///< between the two neighbours: linear, and on the great circle of quaternions
  nearest,
};

/// A motion of the truth onto the estimate before the errors are taken. The estimate never moves, as its
/// covariance would have to move with it.
enum class TruthAlignment {
  none,
  se2,  ///< heading and position in the plane
  yaw,  ///< heading and position in space: what inertial odometry cannot know
  se3,  ///< rotation and position
};

struct TrajectoryMatching {
  double max_time_difference_s = 0.02;  ///< to the truth used: to the nearest, or to both neighbours
  TruthTime truth_time = TruthTime::interpolated;
  TruthAlignment alignment = TruthAlignment::none;
};

/// The rotation vector of R (rad), R = Exp(·), of length at most π.
Eigen::Vector3d rotation_log(const Eigen::Quaterniond& R);

/// The truth at a time, or nothing where it is too far.
std::optional<SpatialPose> truth_at(const Trajectory& truth, double time_s,
                                    const TrajectoryMatching& matching);

/// The motion that takes the points of the truth to those of the estimate with the least squared error
/// ([Umeyama 1991] without scale; heading alone: align_rigidly).
Eigen::Isometry3d align_truth(const std::vector<SpatialPose>& truth, const std::vector<SpatialPose>& estimate,
                              TruthAlignment alignment);

/// Errors of an estimate: position.x … z and orientation.x … z.
struct TrajectoryErrors {
  RunLayout layout;
  std::vector<Step> rows;
  std::int64_t unmatched = 0;  ///< estimates without a truth at their time
};

/// x̂ − x in the axes of the estimate's covariance. Throws DataError when no estimate has a truth at its time.
TrajectoryErrors trajectory_errors(const Trajectory& estimate, const Trajectory& truth,
                                   const TrajectoryMatching& matching);

}  // namespace credence
