#include "datasets/logs/trajectory_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/data_error.h"
#include "datasets/logs/alignment.h"

namespace credence {
namespace {

SpatialPose interpolated(const SpatialPose& a, const SpatialPose& b, double share) {
  return {a.position + share * (b.position - a.position), a.orientation.slerp(share, b.orientation)};
}

/// Heading of the truth turned and moved; z moved only if `height`.
Eigen::Isometry3d align_heading(const std::vector<SpatialPose>& truth,
                                const std::vector<SpatialPose>& estimate, bool height) {
  std::vector<Eigen::Vector2d> from, to;
  double rise = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    from.emplace_back(truth[i].position.head<2>());
    to.emplace_back(estimate[i].position.head<2>());
    rise += (estimate[i].position.z() - truth[i].position.z()) / static_cast<double>(truth.size());
  }
  const Eigen::Isometry2d plane = align_rigidly(from, to);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear().topLeftCorner<2, 2>() = plane.linear();
  motion.translation() << plane.translation(), height ? rise : 0.0;
  return motion;
}

Eigen::Isometry3d align_in_space(const std::vector<SpatialPose>& truth,
                                 const std::vector<SpatialPose>& estimate) {
  Eigen::Matrix3Xd from(3, std::ssize(truth)), to(3, std::ssize(truth));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    from.col(static_cast<Index>(i)) = truth[i].position;
    to.col(static_cast<Index>(i)) = estimate[i].position;
  }
  Eigen::Isometry3d motion;
  motion.matrix() = Eigen::umeyama(from, to, false);
  return motion;
}

Vector pose_error(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes axes) {
  const Eigen::Vector3d position = estimate.position - truth.position;
  const Eigen::Quaterniond& R = truth.orientation;
  const Eigen::Quaterniond& R_hat = estimate.orientation;
  Vector error(6);
  error.head<3>() = axes.position_in_body ? Eigen::Vector3d(R_hat.conjugate() * position) : position;
  error.tail<3>() =
      axes.orientation_in_world ? rotation_log(R_hat * R.conjugate()) : rotation_log(R.conjugate() * R_hat);
  return error;
}

}  // namespace

Eigen::Vector3d rotation_log(const Eigen::Quaterniond& R) {
  const double sign = R.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * R.vec();
  const double sine = v.norm();
  // Near zero 2 asin(s)/s → 2 (1 + s²/6): the quotient is then 2 to rounding.
  if (sine < 1e-9) return 2.0 * v;
  return 2.0 * std::atan2(sine, sign * R.w()) / sine * v;
}

std::optional<SpatialPose> truth_at(const Trajectory& truth, double time_s,
                                    const TrajectoryMatching& matching) {
  const auto begin = truth.time_s.begin(), end = truth.time_s.end();
  const auto after = std::lower_bound(begin, end, time_s);
  const auto pose = [&](auto place) { return truth.poses[static_cast<std::size_t>(place - begin)]; };
  const double limit = matching.max_time_difference_s;
  // Files round their times: what is this near is the same moment.
  constexpr double kSameTime_s = 1e-6;
  if (after != end && *after - time_s <= kSameTime_s) return pose(after);
  if (after != begin && time_s - *(after - 1) <= kSameTime_s) return pose(after - 1);
  const bool has_before = after != begin && time_s - *(after - 1) <= limit;
  const bool has_after = after != end && *after - time_s <= limit;
  if (matching.truth_time == TruthTime::nearest) {
    if (!has_before && !has_after) return std::nullopt;
    if (has_before && has_after)
      return time_s - *(after - 1) <= *after - time_s ? pose(after - 1) : pose(after);
    return has_before ? pose(after - 1) : pose(after);
  }
  if (!has_before || !has_after) return std::nullopt;
  const double share = (time_s - *(after - 1)) / (*after - *(after - 1));
  return interpolated(pose(after - 1), pose(after), share);
}

Eigen::Isometry3d align_truth(const std::vector<SpatialPose>& truth, const std::vector<SpatialPose>& estimate,
                              TruthAlignment alignment) {
  switch (alignment) {
    case TruthAlignment::none:
      break;
    case TruthAlignment::se2:
      return align_heading(truth, estimate, false);
    case TruthAlignment::yaw:
      return align_heading(truth, estimate, true);
    case TruthAlignment::se3:
      return align_in_space(truth, estimate);
  }
  return Eigen::Isometry3d::Identity();
}

TrajectoryErrors trajectory_errors(const Trajectory& estimate, const Trajectory& truth,
                                   const TrajectoryMatching& matching) {
  TrajectoryErrors result;
  std::vector<SpatialPose> true_poses, estimated;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    const std::optional<SpatialPose> pose = truth_at(truth, estimate.time_s[i], matching);
    if (!pose) {
      ++result.unmatched;
      continue;
    }
    true_poses.push_back(*pose);
    estimated.push_back(estimate.poses[i]);
    rows.push_back(i);
  }
  if (rows.empty()) {
    throw DataError(
        estimate.file, "",
        fmt::format("no row has a truth at its time in {}: estimates from {:.3f} to {:.3f} s, truth from "
                    "{:.3f} to {:.3f} s, tolerance {} s",
                    truth.file.string(), estimate.time_s.front(), estimate.time_s.back(),
                    truth.time_s.front(), truth.time_s.back(), matching.max_time_difference_s));
  }
  const Eigen::Isometry3d motion = align_truth(true_poses, estimated, matching.alignment);
  const Eigen::Quaterniond turn(motion.linear());
  result.layout = {
      .states = {"position.x", "position.y", "position.z", "orientation.x", "orientation.y", "orientation.z"},
      .angles = std::vector<bool>(6, false),
      .blocks = {{"position", Part::position, {0, 1, 2}}, {"orientation", Part::other, {3, 4, 5}}},
      .has_truth = true,
      .joint_covariance = estimate.joint_covariance};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SpatialPose moved{motion * true_poses[i].position, turn * true_poses[i].orientation};
    Step row;
    row.step = static_cast<std::int64_t>(i) + 1;
    row.line = estimate.lines[rows[i]];
    row.states = {0, 1, 2, 3, 4, 5};
    row.error = pose_error(estimated[i], moved, estimate.axes);
    row.P = estimate.covariances[rows[i]];
    result.rows.push_back(std::move(row));
  }
  return result;
}

}  // namespace credence
