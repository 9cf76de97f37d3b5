#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A vehicle that flies a closed path in space and reads its odometry, for any of the estimators of
/// core/filters/spatial.
extern const World kSpatialSlamWorld;

}  // namespace credence::internal
