#pragma once

#include "montecarlo/worlds/estimator_contest.h"

namespace credence::internal {

/// The estimators of planar SLAM (core/filters/estimators), compared on the same odometry and measurements.
extern const EstimatorOffer kPlanarSlamOffer;

}  // namespace credence::internal
