#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// The motion and the position measurement of a target: x = [p; v], p⁺ = p + T v, with white noise
/// acceleration of power spectral density q̃ in each coordinate, whose covariance over a step T is q̃ [T³/3,
/// T²/2; T²/2, T].
LinearModel target_model(const Scenario& scenario);

/// The mean of the target's state at the start: abeam of the sensor, on its way along the first axis.
Vector target_start(const Scenario& scenario);

/// States position.x …, velocity.x …; a position and another block. `R` as for linear_layout.
RunLayout target_layout(const Scenario& scenario, const Matrix& R);

}  // namespace credence::internal
