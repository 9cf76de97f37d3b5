#pragma once

#include <cstdint>
#include <string_view>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

/// A root mean square error with its interval.
struct RmseInterval {
  double rmse = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::int64_t count = 0;
  std::string_view reason = {};  ///< why there is no interval (lower, upper NaN), else empty
};

/// The RMSE over independent runs from the moments of their squared errors ‖e‖²: the root of
/// positive_mean_interval (student_positive_mean.h), whose approximations are its own.
///
/// No interval, with a reason, for fewer than two runs or values that are not finite or negative; a zero
/// variance gives the interval [rmse, rmse]. Throws std::invalid_argument unless 0 < confidence < 1.
RmseInterval rmse_interval(const Moments& squared_errors, double confidence);

}  // namespace credence::internal
