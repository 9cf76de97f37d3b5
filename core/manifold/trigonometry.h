#pragma once

#include <cmath>
#include <cstddef>

/// @file
/// Sine, cosine and arc tangent with the same bits on every machine: the library of a system chooses other
/// operations by the processor, and their last bits differ. Errors are below one unit in the last place.

namespace credence::internal {

struct SineCosine {
  double sine, cosine;
};

/// sin x and cos x, x in rad. Beyond 2^20 rad the angle is first taken modulo the double next to 2π, which
/// moves it by less than half a unit in its last place. Not a number where x is none or infinite.
SineCosine sine_cosine(double angle_rad);

inline double sine(double angle_rad) { return sine_cosine(angle_rad).sine; }
inline double cosine(double angle_rad) { return sine_cosine(angle_rad).cosine; }

/// The angle of (x, y) in [−π, π], with the special values of std::atan2.
double arc_tangent(double y, double x);

/// The angle in [−π/2, π/2] whose sine is x, |x| ≤ 1, within two units in the last place.
inline double arc_sine(double x) { return arc_tangent(x, std::sqrt((1.0 - x) * (1.0 + x))); }

/// out[i] = arc_tangent(y[i], x[i]), 0 ≤ i < count, as many at a time as the machine takes.
void arc_tangents(const double* y, const double* x, double* out, std::size_t count);

}  // namespace credence::internal
