#include "analysis/laws/scores/rmse_interval.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/student_positive_mean.h"

namespace credence::internal {

MeanInterval mean_square_interval(const SkewedMoments& squared_errors, double confidence) {
  const auto& [count, mean, m2, m3] = squared_errors;
  MeanInterval interval = positive_mean_interval({.count = count, .mean = mean, .m2 = m2}, confidence);
  if (interval.reason.empty())
    interval.upper = std::max(interval.upper, hall_interval(squared_errors, confidence).upper);
  return interval;
}

RmseInterval rmse_interval(const SkewedMoments& squared_errors, double confidence) {
  const MeanInterval square = mean_square_interval(squared_errors, confidence);
  return {.rmse = std::sqrt(square.mean),
          .lower = std::sqrt(square.lower),
          .upper = std::sqrt(square.upper),
          .count = square.count,
          .reason = square.reason};
}

}  // namespace credence::internal
