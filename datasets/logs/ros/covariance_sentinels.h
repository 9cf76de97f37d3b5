#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/logs/trajectory.h"

namespace credence::internal {

/// Tells numbers that mean "not estimated" from variances: of messages of ROS, whose covariance has always
/// six rows, whatever the filter estimates.
///
/// A variance of 0, at or above 1e5, or not finite is none; −1 in the first element says so of all. A P that
/// never changes while the body moves is a constant that somebody wrote, not an estimate.
class CovarianceSentinels {
 public:
  static constexpr double kNotEstimated = 1e5;

  /// The components that are estimated, ascending; counts the others.
  std::vector<Index> kept(const PoseCovariance& P, const SpatialPose& pose);

  /// Sentences of what was found in `topic`; none where nothing was.
  std::vector<std::string> remarks(const std::string& topic) const;

  /// Whether P was the same in at least ten rows while the body moved by 0.1 m or more.
  bool constant() const;

  /// Whether x, y and yaw were estimated in every row, and nothing else in any.
  bool planar() const;

 private:
  std::array<std::int64_t, 6> zero_{}, large_{}, not_finite_{};
  std::int64_t unknown_ = 0, rows_ = 0;
  PoseCovariance first_ = PoseCovariance::Zero();
  Eigen::Vector3d start_ = Eigen::Vector3d::Zero();
  bool changed_ = false;
  double moved_m_ = 0.0;  ///< the farthest from the start
};

}  // namespace credence::internal
