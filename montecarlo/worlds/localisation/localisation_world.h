#pragma once

#include "montecarlo/worlds/world.h"

namespace credence::internal {

/// A vehicle in the plane that knows its map, or is told its position, and may not know where it looks at the
/// start ([Barrau 2017], section IV).
extern const World kLocalisationWorld;

}  // namespace credence::internal
