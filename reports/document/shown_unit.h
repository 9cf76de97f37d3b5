#pragma once

#include <string>
#include <string_view>

#include "core/manifold/angle.h"

namespace credence::internal {

/// How numbers of a unit are shown.
struct ShownUnit {
  std::string name;    ///< "m/s", "°/s"; empty: not known
  double scale = 1.0;  ///< what turns them into it
};

/// Radians are shown as degrees, "rad/s" as "°/s"; everything else as it is.
inline ShownUnit shown_unit(std::string_view unit) {
  constexpr std::string_view kRadians = "rad";
  if (unit != kRadians && !unit.starts_with("rad/")) return {std::string(unit), 1.0};
  return {"°" + std::string(unit.substr(kRadians.size())), 1.0 / kRadiansPerDegree};
}

/// " (m/s)" behind the name of what has this unit; empty where it is not known.
inline std::string unit_in_brackets(std::string_view unit) {
  return unit.empty() ? "" : " (" + std::string(unit) + ")";
}

}  // namespace credence::internal
