#pragma once

#include <limits>

namespace credence::internal {

/// Stands for a number that is not known; reports say why instead of printing it.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace credence::internal
