#pragma once

#include <Eigen/Cholesky>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/nan.h"
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

/// Mean NEES of such components of samples whose error and covariance `read` writes; NaN where a P is not
/// positive definite.
template <class Read>
double mean_nees(std::span<const PoseSample> samples, std::span<const Index> components, Read read) {
  constexpr int kMost = 6;
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
  double sum = 0.0;
  PoseError error;
  PoseCovariance P;
  for (const PoseSample& sample : samples) {
    read(sample, error, P);
    const Eigen::LLT<Block> factor(P(components, components));
    if (factor.info() != Eigen::Success) return kNaN;
    const Block e = error(components);
    sum += factor.matrixL().solve(e).squaredNorm();
  }
  return sum / static_cast<double>(samples.size());
}

/// The mistakes that people make when they write a log of poses, as readings that undo them, but those of its
/// times (ConventionCheck).
std::vector<PoseReading> mistaken_readings(const PoseChart& declared);

}  // namespace credence::internal
