#include "analysis/laws/scores/rmse_interval.h"

#include <cmath>

#include "analysis/laws/mean/student_positive_mean.h"

namespace credence::internal {

RmseInterval rmse_interval(const Moments& squared_errors, double confidence) {
  const MeanInterval square = positive_mean_interval(squared_errors, confidence);
  return {.rmse = std::sqrt(square.mean),
          .lower = std::sqrt(square.lower),
          .upper = std::sqrt(square.upper),
          .count = square.count,
          .reason = square.reason};
}

}  // namespace credence::internal
