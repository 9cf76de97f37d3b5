#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A vehicle with a strapdown inertial unit and its biases, aided by satellites or landmarks at a lower rate
/// ([Barrau 2017], section V).
extern const World kInertialWorld;

}  // namespace credence::internal
