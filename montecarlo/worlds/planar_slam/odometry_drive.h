#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "montecarlo/random/delay_line.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/random/step_draws.h"
#include "montecarlo/worlds/planar_slam/odometry_world.h"

namespace credence {

/// What odometry and sensor say in one run, whatever filter listens; started, then read step by step.
///
/// Noise of run i: step 0, purpose initial, slots 0 … 2; step k, purpose process, slots 0 and 1 (on the
/// control read); purpose measurement, slots 2l and 2l + 1, and purpose detection, slot l, of landmark l.
/// Nothing is allocated after the construction. `world` must live as long.
class OdometryDrive {
 public:
  OdometryDrive(const OdometryWorld& world, const NoiseSource& source);

  /// Returns where a filter believes the run to start: the truth plus an error of the initial covariance.
  Pose start(std::int64_t run);
  /// The control read of step k, from 1 on: the true one plus noise.
  Control read(std::size_t k);
  /// What was seen at step k, or a delay before; good until the next call.
  std::span<const Observation<PlanarModel>> observe(std::size_t k);

 private:
  const OdometryWorld& world_;
  NoiseSource source_;
  StepDraws process_, measurement_, detection_;
  std::vector<Observation<PlanarModel>> observations_;
  DelayLine<std::vector<Observation<PlanarModel>>> line_;
};

}  // namespace credence
