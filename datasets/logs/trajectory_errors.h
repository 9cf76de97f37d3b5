#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/nan.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/data_error.h"
#include "datasets/logs/conventions/pose_error.h"
#include "datasets/logs/log_sink.h"
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

/// "none", "se2", "yaw" or "se3".
std::string_view to_string(TruthAlignment alignment);

/// Whether the time offset is found from the errors, before all else.
enum class TimeOffsetSearch {
  none,
  together,  ///< one of all files that are judged together
  each,      ///< one of each file
};

/// How estimates and a truth with its own times are brought together.
struct TrajectoryMatching {
  double max_time_difference_s = 0.02;  ///< to the truth used: to the nearest, or to both neighbours
  TruthTime truth_time = TruthTime::interpolated;
  TruthAlignment alignment = TruthAlignment::none;
  /// The truth of an estimate at t is that at t + this. Of logs without poses, which it cannot move, any that
  /// is named is refused, 0 as well.
  std::optional<double> time_offset_s{};
  TimeOffsetSearch find_time_offset = TimeOffsetSearch::none;
  /// Where the frame of the truth is on the estimate's body: moves a truth with orientations onto the
  /// body's own frame, and the estimate to the point of a truth without.
  std::optional<SpatialPose> lever_arm{};
};

}  // namespace credence

namespace credence::internal {

/// The alignment of this name. Throws std::invalid_argument that names all.
TruthAlignment truth_alignment_named(std::string_view name);

/// Of x, y, z, or x, y, z, qx, qy, qz, qw; of nothing, none. Throws std::invalid_argument for other numbers,
/// and for a quaternion that is not of unit length.
std::optional<SpatialPose> lever_arm_of(std::span<const double> numbers);

/// A pose with its covariance, which is zero where it is not known.
struct UncertainPose {
  SpatialPose pose;
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// Files round their times: what is this near is the same moment.
inline constexpr double kSameTime_s = 1e-6;

/// By what a truth may be off where it is taken to be.
struct TruthDeviation {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  ///< on the body, rad
};

/// The share of the way from a to b: linear, and on the great circle of quaternions.
SpatialPose pose_between(const SpatialPose& a, const SpatialPose& b, double share);

/// Between neighbouring rows, of which there must be two.
double mean_interval_s(const Trajectory& truth);

/// The truth at a time, or nothing where it is too far. Between two truths the covariance is the weighted
/// mean of theirs, which no correlation of the two exceeds. With `matching`'s time offset and lever arm, and
/// off by `deviation` as it is written.
std::optional<UncertainPose> truth_at(const Trajectory& truth, double time_s,
                                      const TrajectoryMatching& matching,
                                      const TruthDeviation& deviation = {});

/// The motion that takes the points of the truth to those of the estimate with the least squared error
/// ([Umeyama 1991] without scale; heading alone: align_rigidly), whatever P says of them.
Eigen::Isometry3d align_truth(const std::vector<SpatialPose>& truth, const std::vector<SpatialPose>& estimate,
                              TruthAlignment alignment);

/// One estimate of a trajectory.
struct PoseEstimate {
  double time_s = 0.0;
  std::int64_t line = 0;
  SpatialPose pose;
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// An estimate with those of its six components that are estimated.
struct EstimateSample {
  PoseEstimate estimate;
  std::vector<Index> kept;
};

/// The poses of one file, at most 4096, and their truth; without the latter, none.
struct PosesWithTruth {
  std::vector<EstimateSample> samples;
  std::shared_ptr<const Trajectory> truth;
  PoseErrorAxes axes;
  bool joint_covariance = true;
};

/// Where the frame of the truth was put.
struct TruthPlacement {
  static constexpr double kKnown = 0.02;  ///< the largest share of a variance that the frame may have

  TruthAlignment alignment = TruthAlignment::none;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  ///< of the truth
  bool by_all = false;   ///< by the errors of all rows, of which it takes an unknown part; else by one pose
  double time_s = kNaN;  ///< of that pose
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< that the frame turns about
  PoseCovariance covariance = PoseCovariance::Zero();  ///< of the frame as that pose knows it
};

/// Compares estimates, one after another, with a truth, whose own covariance is added to theirs.
///
/// The states are position.x … z and orientation.x … z (rpy: roll, pitch, yaw), planar vehicle.x, vehicle.y
/// and vehicle.heading; without those of the orientation where the truth has none.
class TruthComparison {
 public:
  /// The truth must outlive this. It is put where `placement` says first.
  TruthComparison(const Trajectory& truth, const TrajectoryMatching& matching, PoseErrorAxes axes,
                  bool joint_covariance, TruthPlacement placement = {});

  const RunLayout& layout() const { return layout_; }

  /// The truth at a time, moved; nothing where there is none.
  std::optional<UncertainPose> truth_at(double time_s, const TruthDeviation& deviation = {}) const;

  /// Writes states, line, error and P of those of the six components that are `kept` (ascending). False,
  /// where none of them is a state.
  bool compare(const PoseEstimate& estimate, const UncertainPose& truth, std::span<const Index> kept,
               Step& step) const;

  /// Whether P of this row, which compare() has written, is not much larger than what the frame of the truth
  /// is known to: its error was used to place the truth.
  bool used_up(const PoseEstimate& estimate, const UncertainPose& truth, const Step& step) const;

  /// Whether the truth of this row, at whose time it may be off by each of `deviations`, leaves too much
  /// open.
  bool is_uncertain(double time_s, const UncertainPose& truth, std::span<const TruthDeviation> deviations,
                    const Step& step) const;

  /// The derivative of the error of this row by motions of the truth's frame about `centre`.
  Matrix frame_jacobian(const PoseEstimate& estimate, const UncertainPose& truth, const Step& step,
                        const Eigen::Vector3d& centre) const;

 private:
  std::vector<Index> components_of(const Step& step) const;

  const Trajectory& truth_;
  TrajectoryMatching matching_;
  PoseErrorAxes axes_;
  TruthPlacement placement_;
  Eigen::Quaterniond turn_;
  RunLayout layout_;
  std::vector<Index> components_;  ///< of the six, the states of the layout
};

/// What tells that no log goes to this time, of another unit than seconds; empty: it may.
std::string no_seconds(double time_s);

/// That no estimate of a file, which are of these times, has a truth at its time.
DataError no_truth(const std::filesystem::path& estimate, double first_s, double last_s,
                   const Trajectory& truth, const TrajectoryMatching& matching);

/// Counts estimates without a truth at their time, and says what takes more where many have none, as the rows
/// of the truth are far apart, or where most have none, as the times of one, which begin at zero, are in
/// another unit. Estimates are of first_s to last_s.
void tell_unmatched(std::int64_t unmatched, std::int64_t rows, double first_s, double last_s,
                    const Trajectory& truth, const TrajectoryMatching& matching, LogSink& sink);

/// Errors of an estimate.
struct TrajectoryErrors {
  RunLayout layout;
  std::vector<Step> rows;
  std::vector<double> time_s;       ///< of each row, of the estimate
  std::vector<double> travelled_m;  ///< by the truth, up to each row
  std::int64_t unmatched = 0;       ///< estimates without a truth at their time
  std::int64_t between_truths = 0;  ///< estimates whose truth may be too far off (TruthGaps)
  std::int64_t used_up = 0;         ///< rows left out, as they placed the truth
  TruthPlacement placement;
};

class ConventionCheck;

/// x̂ − x in the axes of the estimate's covariance, the truth placed where it is aligned (place_truth). Throws
/// DataError when no estimate has a truth at its time. conventions: is shown every row, and tells what it
/// finds to `sink`.
TrajectoryErrors trajectory_errors(const Trajectory& estimate, const Trajectory& truth,
                                   const TrajectoryMatching& matching, ConventionCheck* conventions = nullptr,
                                   LogSink* sink = nullptr);

}  // namespace credence::internal
