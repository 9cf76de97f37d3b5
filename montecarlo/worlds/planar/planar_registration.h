#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A vehicle in the plane that measures range and bearing of landmarks: EKF-SLAM.
extern const World kPlanarWorld;

}  // namespace credence::internal
