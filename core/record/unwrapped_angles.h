#pragma once

#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// Whether a difference of angles [rad] was left unwrapped: it is beyond half a turn and what rounding adds.
inline bool is_unwrapped(double angle_rad) { return std::abs(angle_rad) > std::numbers::pi * (1.0 + 1e-12); }

/// How many components of an innovation were: `angles` says which of each piece are angles; empty: none.
inline std::int64_t count_unwrapped(const Vector& nu, const std::vector<bool>& angles) {
  std::int64_t count = 0;
  for (Index i = 0; i < nu.size() && !angles.empty(); ++i) {
    if (angles[static_cast<std::size_t>(i % std::ssize(angles))] && is_unwrapped(nu[i])) ++count;
  }
  return count;
}

/// "3 innovations of an angle lie beyond half a turn, π rad; once wrapped, and in rad, none can": of those
/// that were counted.
inline std::string unwrapped_text(std::int64_t count) {
  return std::to_string(count) +
         " innovations of an angle lie beyond half a turn, π rad; once wrapped, and in rad, none can";
}

}  // namespace credence::internal
