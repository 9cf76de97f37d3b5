#pragma once

#include <span>

#include "core/models/range_bearing.h"
#include "core/nan.h"
#include "montecarlo/lanes/lane_numbers.h"
#include "montecarlo/lanes/planar_nees_kernel.h"

namespace credence::internal {

/// NEES of the runs of PlanarLanes from step to step, O(n) a step: NeesAlongRun for eight runs at a time.
///
/// A lane has a value unless its pose given the map is singular, as after an exact start, or distrust() was
/// told so. A lane's bits depend on its own run alone, and not on the instruction set.
class PlanarNeesLanes {
 public:
  /// Of `states` numbers, the map complete, and at most `measured` landmarks and anchors in an update.
  PlanarNeesLanes(Index states, Index measured, InstructionSet set);

  /// Starts a run with an empty map and the covariance P of the pose.
  void reset(int lane, const Eigen::Matrix3d& P);
  /// The motion of a step, as PlanarLanesKernel::predict takes it.
  void move(const double* F, const double* GQG);
  /// In place of the motion: P, before the update, has a map that is block diagonal.
  void start(const PlanarLanesData& filter);
  /// What the last update measured; `prior` (3) is the error of the predicted pose. `logarithms`: ln det P is
  /// wanted.
  void correct(const PlanarLanesData& filter, const LaneNumbers& prior, bool logarithms);
  /// A new landmark at `state`, with J_r and J_z R J_zᵀ; the errors are those of the state now, and `known`
  /// has the lanes that know each landmark.
  void append(int lane, Index state, const Eigen::Matrix<double, 2, 3>& J_r, const Eigen::Matrix2d& noise,
              const LaneNumbers& error, std::span<const LaneSet> known);
  /// The values of the state's `error` (n), which is that of the map before the next update.
  void judge(const PlanarLanesData& filter, const LaneNumbers& error);

  bool has_value(int lane) const { return has(valued_, lane); }
  bool all_have_values(LaneSet of) const { return (of & ~valued_) == 0; }
  /// A lane without a value from now on, until its next run.
  void distrust(int lane);

  double nees(int lane) const { return nees_[lane]; }
  double map_nees(int lane) const { return map_nees_[lane]; }
  double vehicle_nees(int lane) const { return vehicle_nees_[lane]; }
  Eigen::Vector3d vehicle_whitened(int lane) const;
  double log_determinant(int lane) const;

  // Of the last judge() as well, whether there is a value or not.
  double trace(int lane) const { return trace_[lane]; }                  ///< tr P
  Index dof(int lane) const { return static_cast<Index>(dof_[lane]); }   ///< variances that are not zero
  double map_error(int lane) const { return squared_map_error_[lane]; }  ///< e_fᵀ e_f
  /// The largest |e_i|; not a number where an error is none.
  double largest_error(int lane) const { return finite_[lane] == 0.0 ? largest_[lane] : kNaN; }

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  PlanarNeesData kernel_data(const LaneNumbers& error, const double* prior = nullptr);

  const PlanarNeesKernel& kernel_;
  Index states_;
  LaneNumbers Sigma_, A_, w_, map_error_, tells_, scalars_, determinants_, vehicle_white_;
  Lanes nees_, map_nees_, vehicle_nees_, doubt_, inverse_root_, map_log_determinant_, trace_, dof_,
      squared_map_error_, largest_, finite_;
  LaneSet trusted_ = 0, valued_ = 0;
};

}  // namespace credence::internal
