#pragma once

#include <memory>
#include <vector>

#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"
#include "montecarlo/worlds/planar_slam/odometry_simulation.h"

namespace credence::internal {

/// normalised_error of a P of which the lower triangle is read. Cheap where P has a Cholesky factor whose
/// pivots are not rounding. dof −1: P is not psd or not finite.
class SingularNees {
 public:
  NeesValue solve(const VectorRef& error, const MatrixRef& P) { return solve(error, P, Vector()); }
  /// The same without the states that are certain of these estimates (find_certain_states).
  NeesValue solve(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate);
  /// The same, and of dof 0 where the error lies in part where P claims certainty, as a row of a log is
  /// rejected.
  NeesValue judge(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate);

 private:
  NeesSolver solver_;
  std::vector<Index> certain_;
  bool leaves_range_ = false;  ///< an error of the last solve, where P claims certainty
};

/// One estimator in one run after the other of a world; what it hears comes from an OdometrySimulation, which
/// several may share.
class EstimatorRun {
 public:
  /// `world` must live as long.
  EstimatorRun(const OdometryWorld& world, std::unique_ptr<SlamEstimator> filter);

  /// Starts a run where the filter believes to be.
  void start(const Pose& estimate);
  /// Step k, from 1 on. `diverged` for an estimate that is not finite or farther off than the world is wide.
  Outcome step(std::size_t k, const Control& read, std::span<const Observation<PlanarModel>> seen);

  const SlamEstimator& filter() const { return *filter_; }
  const UpdateResult& update() const { return update_; }
  PlanarTruth truth() const { return world_.truth(step_); }
  /// The error of the estimate in the chart of its P.
  VectorRef error() const { return error_.head(filter_->size()); }
  /// x̂ − x of the pose, the heading wrapped.
  Pose plane_error() const;

 private:
  const OdometryWorld& world_;
  std::unique_ptr<SlamEstimator> filter_;
  std::size_t step_ = 0;
  UpdateResult update_;
  Vector error_;
};

}  // namespace credence::internal
