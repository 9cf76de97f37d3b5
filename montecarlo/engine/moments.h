#pragma once

#include <cstdint>

namespace credence {

/// Count, mean and sum of squared deviations of a sample: what adds up, from which the rest is derived.
///
/// Merging follows [Chan 1983]; it is associative only up to rounding, so whoever wants
/// the same bits merges in one fixed order.
struct Moments {
  std::int64_t count = 0;
  double mean = 0.0;
  double m2 = 0.0;  ///< Σ (x − mean)²

  /// Adds one value [Welford 1962].
  void add(double x) {
    ++count;
    const double delta = x - mean;
    mean += delta / static_cast<double>(count);
    m2 += delta * (x - mean);
  }

  /// Adds all values of `other`.
  void merge(const Moments& other) {
    if (other.count == 0) return;
    if (count == 0) {
      *this = other;
      return;
    }
    const double na = static_cast<double>(count);
    const double nb = static_cast<double>(other.count);
    const double delta = other.mean - mean;
    count += other.count;
    mean += delta * (nb / (na + nb));
    m2 += other.m2 + delta * delta * (na * nb / (na + nb));
  }

  /// Unbiased sample variance; 0 for fewer than two values.
  double variance() const { return count < 2 ? 0.0 : m2 / static_cast<double>(count - 1); }

  bool operator==(const Moments&) const = default;
};

}  // namespace credence
