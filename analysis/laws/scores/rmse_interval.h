#pragma once

#include <cstdint>
#include <string_view>

#include "analysis/laws/mean/student.h"
#include "montecarlo/engine/skewed_moments.h"

namespace credence::internal {

/// A root mean square error with its interval.
struct RmseInterval {
  double rmse = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::int64_t count = 0;
  std::string_view reason = {};  ///< why there is no interval (lower, upper NaN), else empty
};

/// The mean over independent runs of their squared errors ‖e‖², averaged over steps or not: as far below as
/// the cube root of a gamma law lets it be (student_positive_mean.h), and as far above as it or Hall's score
/// does (hall_score.h), where the cube root alone is short. Levels are in docs/statistics.md.
///
/// No interval, with a reason, for fewer than two runs or values that are not finite or negative; a zero
/// variance gives the interval [mean, mean]. Throws std::invalid_argument unless 0 < confidence < 1.
MeanInterval mean_square_interval(const SkewedMoments& squared_errors, double confidence);

/// The RMSE: its root, under the same conditions.
RmseInterval rmse_interval(const SkewedMoments& squared_errors, double confidence);

}  // namespace credence::internal
