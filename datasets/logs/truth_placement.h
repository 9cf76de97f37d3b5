#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "datasets/logs/trajectory_errors.h"

/// @file
/// Where the frame of a truth lies that is aligned with an estimate.
///
/// What a placement takes out of the errors depends on how they are correlated in time, which no log tells.
/// It is known only of a placement by a single pose a: with C the covariance of the frame that P_a leaves,
/// errors J_k of a unit of the frame, and C small beside what is judged, J_k C J_kᵀ ≤ κ P_k, the covariance
/// of the error of row k lies within (1 ± √κ)² P_k whatever its correlation with that of row a, and is (1 ±
/// κ) P_k of an odometry, whose errors contain that of the pose it began with, and of errors that are
/// independent. Of all placements the one of least Σ e_kᵀ P_k⁻¹ e_k has a mean NEES that is no larger than
/// that of the right one, so that a mean NEES that is too large is so wherever the truth lies; nothing else
/// that it shows is known.

namespace credence::internal {

/// Whether the time or the place of the truth is fitted to the estimates, for which samples are needed.
bool is_fitted(const TrajectoryMatching& matching);

/// At most 4096 poses of a trajectory, evenly spread; none where nothing is fitted.
std::vector<EstimateSample> pose_samples(const Trajectory& estimate, const TrajectoryMatching& matching);

/// The motion of the truth, of the kind of `matching`, for which Σ e_kᵀ P_k⁻¹ e_k over every stride-th sample
/// is least (Gauss-Newton). The identity without alignment, or where no sample has a truth.
Eigen::Isometry3d fitted_motion(std::span<const EstimateSample> samples, const Trajectory& truth,
                                const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance,
                                std::size_t stride = 1);

/// The place of the truth: by the pose that knows the frame best, where what it leaves of the frame is at
/// most kKnown of P in every direction in half of the samples or more; else by all.
TruthPlacement place_truth(std::span<const EstimateSample> samples, const Trajectory& truth,
                           const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance);

/// Tells `sink` how the truth was placed, if it was.
void tell_placement(const TruthPlacement& placement, std::int64_t used_up, LogSink& sink);

}  // namespace credence::internal
