#pragma once

#include <cstdint>
#include <string_view>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

/// An estimated mean with its confidence interval.
struct MeanInterval {
  double mean = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  double standard_error = 0.0;
  std::int64_t count = 0;
  std::string_view reason = {};  ///< why there is no interval (lower, upper NaN), else empty

  double half_width() const { return 0.5 * (upper - lower); }
};

/// The interval of a mean over independent runs from their empirical variance, by Student's t.
///
/// The right interval for the mean NEES of a filter that may be inconsistent: its NEES is then not χ²
/// (theory, section 7). Approximate for skewed values and few runs; no interval, with a reason, for fewer
/// than two values or a mean that is not finite. A zero variance gives the interval [mean, mean]. Throws
/// std::invalid_argument unless 0 < confidence < 1.
MeanInterval student_interval(const Moments& moments, double confidence);

/// The t with P(|T| ≤ t) = confidence, T ~ t(dof). Throws std::invalid_argument unless dof > 0 and
/// 0 < confidence < 1.
double student_quantile_two_sided(double confidence, double dof);

/// P(T ≥ t), T ~ t(dof); NaN for a NaN t.
double student_upper_p_value(double t, double dof);

/// P(|T| ≥ |t|), T ~ t(dof); NaN for a NaN t.
double student_two_sided_p_value(double t, double dof);

}  // namespace credence::internal
