#pragma once

#include <numbers>

#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// Metres once round the path: a circle, two circles for the eight, forth and back for the line.
inline double loop_length_m(PathShape path, double radius_m) {
  if (path == PathShape::line) return 4.0 * radius_m;
  return (path == PathShape::eight ? 4.0 : 2.0) * std::numbers::pi * radius_m;
}

}  // namespace credence::internal
