#pragma once

#include "montecarlo/worlds/plugged/model_plug.h"
#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A pendulum that white noise drives, of which the horizontal displacement is measured: the textbook example
/// of the extended and the unscented Kalman filter.
extern const World kPendulumWorld;

/// x = (α, ω): α⁺ = α + ω dt, ω⁺ = ω − g sin(α) dt, and z = sin(α) ([Särkkä 2013], example 3.7), with the
/// process noise of white acceleration of density q, q [dt³/3, dt²/2; dt²/2, dt].
FunctionModel pendulum_model(const Scenario& scenario);

}  // namespace credence::internal
