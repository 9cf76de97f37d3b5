#include "analysis/laws/mean/equivalence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {

double equivalence_p_value(const SkewedMoments& run_averages, double delta) {
  require_positive("delta", delta);
  const double too_large = run_mean_p_values(run_averages, 1.0 + delta).pessimistic;
  const double too_small = run_mean_p_values(run_averages, 1.0 / (1.0 + delta)).optimistic;
  return std::isnan(too_large) ? kNaN : std::max(too_large, too_small);
}

double proved_within(const SkewedMoments& run_averages, double confidence) {
  if (!(confidence >= 0.5 && confidence < 1.0)) {
    throw std::invalid_argument(fmt::format("confidence = {} must lie in [0.5, 1)", confidence));
  }
  if (confidence == 0.5) return kNaN;  // an interval that never covers
  const MeanInterval interval = run_mean_interval(run_averages, 2.0 * confidence - 1.0);
  if (!interval.reason.empty()) return kNaN;
  if (interval.lower <= 0.0) return std::numeric_limits<double>::infinity();
  return std::max(interval.upper, 1.0 / interval.lower) - 1.0;
}

}  // namespace credence::internal
