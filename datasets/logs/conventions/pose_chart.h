#pragma once

#include <span>
#include <string_view>

#include "datasets/logs/conventions/pose_error.h"

namespace credence {

/// How a library writes the covariance of a pose.
struct PoseChart {
  std::string_view name;  ///< of --chart
  std::string_view says;  ///< for reports
  internal::PoseErrorAxes axes;
  bool rotation_first = false;

  /// A covariance as it is written, with the position first.
  internal::PoseCovariance position_first(const internal::PoseCovariance& written) const;
};

/// All of them. Sources are in docs/logs.md.
std::span<const PoseChart> pose_charts();

/// The chart of this name. Throws std::invalid_argument that names all.
const PoseChart& pose_chart_named(std::string_view name);

/// The chart that --orientation-error means: position in the world and first, rotation vectors.
const PoseChart& pose_chart_of(internal::OrientationError orientation);

}  // namespace credence
