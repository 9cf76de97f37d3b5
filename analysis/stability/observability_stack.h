#pragma once

#include "analysis/stability/ranks.h"
#include "core/filters/estimators/slam_estimator.h"

namespace credence {

/// The local observability matrix of a planar SLAM estimator along a run at the Jacobians that it used, the
/// stack of H_k Φ_k with Φ_k = F_k … F_1 ([Huang 2010]), kept as its triangular factor: O(n²) of
/// memory, and of time per measured number.
///
/// A landmark's first sight at z gives the rows [−J_r, I] Φ_k of its placement.
class ObservabilityStack {
 public:
  /// `states`: n of the complete state.
  explicit ObservabilityStack(Index states);

  /// Takes what the last step of `filter` used.
  void add(const SlamEstimator& filter);

  /// The rank; the directions that no measurement tells are states() less this.
  RankDecision rank(double tolerance = kRankTolerance);
  /// The pose and the landmarks that were placed.
  Index states() const { return known_; }

 private:
  void add_row(const VectorRef& row);
  void reduce();

  Index states_, rows_ = 0, known_ = 3;
  Eigen::Matrix3d transition_ = Eigen::Matrix3d::Identity();  ///< the pose block of Φ_k; the rest is I
  Matrix stack_;                                              ///< the triangular factor over new rows
  Vector row_;
};

}  // namespace credence
