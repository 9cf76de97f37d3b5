#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datasets/logs/conventions/pose_chart.h"

namespace credence::internal {

/// An estimate as it is written, and its truth.
struct PoseSample {
  double time_s = 0.0;
  SpatialPose estimate, truth;
  PoseCovariance written = PoseCovariance::Zero();           ///< of the estimate, as it is written
  PoseCovariance truth_covariance = PoseCovariance::Zero();  ///< in kFixedAxes
};

/// One way to read a log of poses.
struct PoseReading {
  std::string cause;   ///< "the rotation's covariance is of half angles, …"
  std::string repair;  ///< what to do about it
  PoseChart chart;
  /// Changes what is written, and the poses, into what was meant; nothing for none. False: not for this one.
  std::function<bool(PoseSample&)> change{};

  /// The error in the chart and its covariance. Of charts of half angles (RotationUnit) the rotation's rows
  /// are times 2, so that those of all charts are rad to first order: of half_vector the rotation vector e,
  /// of quaternion_part (g2o) 2 sin(|e|/2) e/|e|.
  bool read(PoseSample sample, PoseError& error, PoseCovariance& P) const;
};

/// The truth at a time; false where there is none.
using TruthLookup = std::function<bool(double time_s, SpatialPose& truth)>;

/// The mistakes that people make when they write a log of poses, as readings that undo them. `spacing_s`:
/// the time between two estimates.
std::vector<PoseReading> mistaken_readings(const PoseChart& declared, double spacing_s,
                                           const TruthLookup& truth_at);

}  // namespace credence::internal
