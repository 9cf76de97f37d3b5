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
/// runs where there are ten, else over stretches; of five long ones, for squared autoregressions of 873
/// values with correlation times of 33 and 66 values, it missed in 7 % of 1000 recordings each at 95 %.
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
