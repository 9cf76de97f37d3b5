#pragma once

#include "core/manifold/trigonometry.h"

namespace credence::internal {

/// s_1 … s_5 of an angle θ, s_m = Σ_n (−1)ⁿ θ²ⁿ / (2n + m)!: of what the closed forms of the groups of
/// rotations and rigid motions are made.
///
/// s_1 = sin θ / θ, s_2 = (1 − cos θ) / θ², s_3 = (θ − sin θ) / θ³, s_4 = (θ²/2 − 1 + cos θ) / θ⁴,
/// s_5 = (sin θ − θ + θ³/6) / θ⁵. Where the quotients lose digits the series itself is summed.
struct TrigonometricSeries {
  double s1, s2, s3, s4, s5;
};

inline TrigonometricSeries trigonometric_series(double theta) {
  const double q = theta * theta;
  // s_m = 1/m! − θ² s_{m+2}: stable downwards for a small angle, upwards for a large one.
  if (q < 1.0) {
    constexpr int kTerms = 9;  // the next is below 1e-18 of the sum
    double s4 = 1.0, s5 = 1.0;
    for (int n = kTerms; n > 0; --n) {
      s4 = 1.0 - q / ((2.0 * n + 3.0) * (2.0 * n + 4.0)) * s4;
      s5 = 1.0 - q / ((2.0 * n + 4.0) * (2.0 * n + 5.0)) * s5;
    }
    s4 /= 24.0;
    s5 /= 120.0;
    const double s3 = 1.0 / 6.0 - q * s5;
    return {1.0 - q * s3, 0.5 - q * s4, s3, s4, s5};
  }
  const double s1 = sine(theta) / theta, half = sine(0.5 * theta);
  const double s2 = 2.0 * half * half / q, s3 = (1.0 - s1) / q;
  return {s1, s2, s3, (0.5 - s2) / q, (1.0 / 6.0 - s3) / q};
}

}  // namespace credence::internal
