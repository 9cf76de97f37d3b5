#pragma once

#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {

/// The posterior Cramér-Rao bound of SLAM in the plane, of pose and map: nothing is known of a landmark
/// before.
///
/// A truth drives its controls with their noise. Errors of pose and landmarks are taken in the axes of its
/// vehicle, turned by the heading that the vehicle would have without noise: there motion depends on the
/// control alone, taken as it is told, and a measurement on where the landmark lies from the vehicle, whose
/// Hᵀ R⁻¹ H is a mean over truths, a landmark out of sight telling nothing. Turned axes leave the sums of
/// squares as they are. A landmark starts once its own block of the mean information can be inverted.
///
/// O(n²) a landmark in view; a world too large has a reason.
PosteriorBound planar_bound(const Scenario& scenario);

}  // namespace credence::internal
