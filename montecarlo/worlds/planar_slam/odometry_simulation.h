#pragma once

#include <cstdint>
#include <span>

#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/landmark_draws.h"
#include "montecarlo/worlds/planar_slam/odometry_world.h"

namespace credence::internal {

/// What odometry and sensor say in one run, whatever filter listens; started, then read step by step.
///
/// Noise of run i: step 0, purpose initial, slots 0 … 2; then LandmarkDraws, that of the motion on the
/// control read. Nothing is allocated after the construction. `world` must live as long.
class OdometrySimulation {
 public:
  OdometrySimulation(const OdometryWorld& world, const NoiseSource& source);

  /// Returns where a filter believes the run to start: the truth plus an error of the initial covariance.
  Pose start(std::int64_t run);
  /// The control read of step k, from 1 on: the true one plus noise.
  Control read(std::size_t k);
  /// What was seen at step k, or a delay before; good until the next call.
  std::span<const Observation<PlanarModel>> observe(std::size_t k);

 private:
  const OdometryWorld& world_;
  NoiseSource source_;
  LandmarkDraws<Observation<PlanarModel>> draws_;
};

}  // namespace credence::internal
