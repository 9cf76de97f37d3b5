#pragma once

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/plugged/model_plug.h"

namespace credence::internal {

/// x = (α, ω): α⁺ = α + ω dt, ω⁺ = ω − g sin(α) dt, and z = sin(α) ([Särkkä 2013], example 3.7), with the
/// process noise of white acceleration of density q, q [dt³/3, dt²/2; dt²/2, dt].
FunctionModel pendulum_model(const Scenario& scenario);

}  // namespace credence::internal
