#pragma once

#include "montecarlo/worlds/posterior_bound.h"
#include "montecarlo/worlds/spatial_slam/spatial_world.h"

namespace credence::internal {

/// The posterior Cramér-Rao bound of the pose, as that of planar_slam/odometry_bound.h.
PosteriorBound spatial_bound(const SpatialWorld& world);

}  // namespace credence::internal
