#pragma once

#include "montecarlo/worlds/estimator_contest.h"

/// @file
/// The worlds whose estimators can be compared, on the same noise each.

namespace credence::internal {

extern const EstimatorOffer kLinearOffer;      ///< of a linear world (core/filters/linear_estimators.h)
extern const EstimatorOffer kPlanarSlamOffer;  ///< of planar SLAM (core/filters/estimators)
extern const EstimatorOffer kSpatialOffer;     ///< of SLAM in space (core/filters/spatial)

}  // namespace credence::internal
