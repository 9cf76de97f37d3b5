#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>

#include "datasets/logs/trajectory_errors.h"

namespace credence::internal {

/// What makes a truth of a time: `share` of the way from a row to the next one; 0: that row alone.
struct TruthRows {
  std::size_t row = 0;
  double share = 0.0;
};

/// Those of a truth whose rows are in order of time; nothing where they are too far. Of a row of the same
/// time it alone; between two that are as near the earlier is the nearest.
template <class Rows, class TimeOf = std::identity>
std::optional<TruthRows> truth_rows(const Rows& rows, double time_s, const TrajectoryMatching& matching,
                                    TimeOf time_of = {}) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto after = std::ranges::lower_bound(rows, time_s, {}, time_of);
  const auto next = static_cast<std::size_t>(after - rows.begin());
  const double to_next = after != rows.end() ? std::invoke(time_of, *after) - time_s : kNone;
  const double to_last = next > 0 ? time_s - std::invoke(time_of, *std::prev(after)) : kNone;
  if (to_next <= kSameTime_s) return TruthRows{next};
  if (to_last <= kSameTime_s) return TruthRows{next - 1};
  const double limit = matching.max_time_difference_s;
  if (matching.truth_time == TruthTime::nearest) {
    if (std::min(to_last, to_next) > limit) return std::nullopt;
    return TruthRows{to_last <= to_next ? next - 1 : next};
  }
  if (std::max(to_last, to_next) > limit) return std::nullopt;
  return TruthRows{next - 1,
                   to_last / (std::invoke(time_of, *after) - std::invoke(time_of, *std::prev(after)))};
}

}  // namespace credence::internal
