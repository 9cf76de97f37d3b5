#pragma once

#include "montecarlo/worlds/planar_slam/odometry_world.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {

/// The posterior Cramér-Rao bound of pose and map. The vehicle never leaves its path, so that all means are
/// the Jacobians on it, but for the observations that are missed, E[Hᵀ R⁻¹ H] = p Hᵀ R⁻¹ H: P of a filter
/// with its Jacobians at the truth. Of the map nothing is known before. Noise is the world's, whatever a
/// filter believes. O(n²) a step.
PosteriorBound odometry_bound(const OdometryWorld& world);

}  // namespace credence::internal
