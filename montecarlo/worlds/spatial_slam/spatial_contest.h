#pragma once

#include "montecarlo/worlds/estimator_contest.h"

namespace credence::internal {

/// The estimators of SLAM in space (core/filters/spatial), compared on the same odometry and measurements.
extern const EstimatorOffer kSpatialOffer;

}  // namespace credence::internal
