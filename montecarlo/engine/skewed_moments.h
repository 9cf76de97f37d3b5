#pragma once

#include <cstdint>

namespace credence::internal {

/// Count, mean and the sums of second and third powers of the deviations of a sample: what a test needs that
/// corrects for skewness.
///
/// Merging follows Pébay (2008, eqs 2.1 to 2.3), for the second power Chan, Golub and LeVeque (1983); it is
/// associative only up to rounding, so whoever wants the same bits merges in one fixed order.
struct SkewedMoments {
  std::int64_t count = 0;
  double mean = 0.0;
  double m2 = 0.0;  ///< Σ (x − mean)²
  double m3 = 0.0;  ///< Σ (x − mean)³

  /// Adds one value.
  void add(double x) { merge({.count = 1, .mean = x}); }

  /// Adds all values of `other`.
  void merge(const SkewedMoments& other) {
    if (other.count == 0) return;
    if (count == 0) {
      *this = other;
      return;
    }
    const double na = static_cast<double>(count);
    const double nb = static_cast<double>(other.count);
    const double n = na + nb;
    const double delta = other.mean - mean;
    const double pair = delta * delta * (na * nb / n);
    m3 += other.m3 + pair * delta * ((na - nb) / n) + 3.0 * delta * (na * other.m2 - nb * m2) / n;
    m2 += other.m2 + pair;
    mean += delta * (nb / n);
    count += other.count;
  }

  /// Unbiased sample variance; 0 for fewer than two values.
  double variance() const { return count < 2 ? 0.0 : m2 / static_cast<double>(count - 1); }

  bool operator==(const SkewedMoments&) const = default;
};

}  // namespace credence::internal
