#pragma once

#include "montecarlo/worlds/estimator_contest.h"

namespace credence::internal {

/// The estimators of a linear world (core/filters/linear_estimators.h), compared on the same noise.
extern const EstimatorOffer kLinearOffer;

}  // namespace credence::internal
