#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "datasets/logs/trajectory_errors.h"

namespace credence {

/// The mean NEES of a pose in each meaning that the orientation's part of its covariance may have: authors
/// write what their filter has, whatever the standard says.
class OrientationComparison {
 public:
  /// Only steps with all six components count.
  void add(const PoseEstimate& estimate, const UncertainPose& truth, std::span<const Index> kept);

  /// A sentence where two of them differ by more than a tenth; else "".
  std::string remark(OrientationError judged) const;

 private:
  static constexpr std::array kKinds = {OrientationError::world, OrientationError::body,
                                        OrientationError::rpy};

  std::array<double, kKinds.size()> sums_{};
  std::int64_t count_ = 0;
};

/// "world", "body", "rpy", "planar".
std::string_view to_string(OrientationError kind);

}  // namespace credence
