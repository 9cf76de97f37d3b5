#pragma once

#include "core/filters/estimators/slam_estimator.h"

namespace credence::internal {

/// The rows of the local observability matrix of a planar SLAM estimator along a run at the Jacobians that it
/// used, H_k Φ_k with Φ_k = F_k … F_1 ([Huang 2010]). A landmark's first observation gives the rows
/// [−J_r, I] Φ_k of its placement.
class JacobianRows {
 public:
  /// `states`: n of the complete state.
  explicit JacobianRows(Index states) : row_(states) {}

  /// Hands on the rows of the last step of `filter`, each n: `take(row)`.
  template <class Take>
  void add(const SlamEstimator& filter, const Take& take) {
    transition_ = filter.motion_jacobian() * transition_;
    const MatrixRef H = filter.measurement_jacobian();
    for (Index r = 0; r < H.rows(); ++r) {
      row_.setZero();
      row_.head<3>() = (H.row(r).head<3>() * transition_).transpose();
      for (Index j = 3; j < H.cols(); ++j) row_[filter.seen()[static_cast<std::size_t>(j)]] = H(r, j);
      take(row_);
    }
    for (const Eigen::Matrix<double, 2, 3>& J_r : filter.placements()) {
      for (Index axis = 0; axis < 2; ++axis, ++known_) {
        row_.setZero();
        row_.head<3>() = -(J_r.row(axis) * transition_).transpose();
        row_[known_] = 1.0;
        take(row_);
      }
    }
  }

  /// The pose and the landmarks that were placed.
  Index states() const { return known_; }

 private:
  Index known_ = 3;
  Eigen::Matrix3d transition_ = Eigen::Matrix3d::Identity();  ///< the pose block of Φ_k; the rest is I
  Vector row_;
};

}  // namespace credence::internal
