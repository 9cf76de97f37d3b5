#pragma once

#include "core/stop_point.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/worlds/spatial_slam/spatial_world.h"

namespace credence::internal {

/// One estimator in one run after the other of a world; what it hears comes from a SpatialSimulation.
class SpatialRun {
 public:
  /// `world` must live as long.
  SpatialRun(const SpatialWorld& world, const SpatialKind& kind)
      : world_(world), filter_(kind, std::ssize(world.landmarks)) {}

  void start(const SE3& estimate) { filter_.reset(estimate, world_.initial_covariance()); }
  /// Step k, from 1 on. `diverged` for an estimate that is not finite or farther off than the world is wide.
  Outcome step(std::size_t k, const SpatialControl& read, std::span<const SpatialObservation> observations) {
    stop_point();
    step_ = k;
    const SpatialTruth truth = world_.truth(k);
    filter_.predict(read, truth);
    if (!filter_.update(observations, truth)) return Outcome::not_positive_definite;
    if (!filter_.is_finite()) return Outcome::diverged;
    const double off = (filter_.pose().translation() - truth.now.translation()).norm();
    return off > world_.width_m ? Outcome::diverged : Outcome::ok;
  }
  const SpatialSlam& filter() const { return filter_; }
  SpatialTruth truth() const { return world_.truth(step_); }  ///< at the last step

 private:
  const SpatialWorld& world_;
  SpatialSlam filter_;
  std::size_t step_ = 0;
};

}  // namespace credence::internal
