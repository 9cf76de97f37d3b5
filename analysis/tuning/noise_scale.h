#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace credence::internal {

/// By what all covariances (P0, Q and R) must be multiplied for the mean NIS to be the expected one.
///
/// The gain does not change when they all scale together, and so neither do the innovations; inflation scales
/// with P. Hence the scale is exact for every EKF without a gate. With a gate the innovations are taken as
/// scaled χ² that were cut. The interval is that of a positive mean, of all values as the scale, over whole
/// runs where there are ten, else over stretches of twelve correlation times of all runs together, at most
/// twenty; its upper end is that of hall_score.h where this lies further out. At 95 % it missed in this
/// share of 1000 recordings each: a random walk with Q = 0.1, R = 1 whose filter assumes Q, Q/20 and Q/100,
/// and squared autoregressions with correlation times of 33 and 66 values.
///
/// | runs × values | 1×200 | 1×1000 | 3×100 | 5×40 | 5×60 | 5×300 | 12×60 |
/// |---------------|-------|--------|-------|------|------|-------|-------|
/// | Q             | 4.8   |        |       | 4.6  |      |       |       |
/// | Q/20          | 8.2   | 5.9    | 9.0   |      |      |       | 5.3   |
/// | Q/100         |       | 6.6    |       |      | 8.0  | 8.4   | 5.0   |
///
/// The autoregressions, 873 values: 5.7 and 7.5 %.
struct NoiseScale {
  double scale = 0.0;  ///< of variances; below 1: the filter is pessimistic
  double lower = 0.0, upper = 0.0;
  std::int64_t stretches = 0;    ///< nearly independent parts that the interval rests on
  std::string_view reason = {};  ///< why there is no interval (bounds NaN), else empty
};

/// NIS of independent runs, each in order of time.
using NisOfRuns = std::span<const std::vector<double>>;

/// Of values of one dof, which all lie within the gate; ∞: there is none.
NoiseScale noise_scale(NisOfRuns runs, double dof, double gate, double confidence);

}  // namespace credence::internal
