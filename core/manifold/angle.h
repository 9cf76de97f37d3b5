#pragma once

#include <cmath>
#include <numbers>

namespace credence::internal {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

}  // namespace credence::internal

namespace credence {

/// The angle equal to `angle_rad` modulo 2π that lies in (−π, π].
///
/// The one place where angles are wrapped: states, innovations and errors all come through here.
/// A non-finite angle stays non-finite (NaN).
inline double wrap_angle(double angle_rad) {
  constexpr double kPi = std::numbers::pi;
  if (angle_rad > -kPi && angle_rad <= kPi) return angle_rad;
  // Within a turn the difference is exact, and is what the remainder would be, only sooner.
  if (angle_rad > kPi && angle_rad < 3.0 * kPi) return angle_rad - 2.0 * kPi;
  if (angle_rad < -kPi && angle_rad > -3.0 * kPi) return angle_rad + 2.0 * kPi;
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace credence
