#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A vehicle that drives a circle and reads its odometry, for any of the estimators of
/// core/filters/estimators.
extern const World kPlanarSlamWorld;

}  // namespace credence::internal
