#include "analysis/tuning/stretches.h"

#include <cmath>

#include "analysis/laws/mean/effective_sample.h"
#include "core/nan.h"

namespace credence::internal {

double correlation_time_of(std::span<const double> values) {
  if (values.empty()) return kNaN;
  const EffectiveSample sample = effective_sample(values);
  return sample.reason.empty() ? sample.correlation_time : kNaN;
}

std::int64_t stretch_count(std::size_t length, double correlation_time) {
  constexpr double kTimesAStretch = 8.0;
  if (!std::isfinite(correlation_time)) return 0;
  return static_cast<std::int64_t>(static_cast<double>(length) / (kTimesAStretch * correlation_time));
}

}  // namespace credence::internal
