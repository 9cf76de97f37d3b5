#pragma once

#include "montecarlo/worlds/world.h"

namespace credence {

/// A vehicle in the plane that measures range and bearing of landmarks: EKF-SLAM.
extern const World kPlanarWorld;

}  // namespace credence
