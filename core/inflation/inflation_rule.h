#pragma once

#include <optional>

#include "core/inflation/inflation.h"
#include "core/inflation/rank_one_bound.h"
#include "core/types.h"

namespace credence::internal {

/// The bound of a solution that inflates within the update, O(N); none of one that inflates before it.
inline std::optional<MapBound> map_bound(InflationSolution solution) {
  if (solution == InflationSolution::sequential) return MapBound::least_trace;
  if (solution == InflationSolution::batch) return MapBound::batch;
  if (solution == InflationSolution::drop) return MapBound::drop;
  return std::nullopt;
}

}  // namespace credence::internal

namespace credence {

/// The covariance inflation of a filter: a rule that decorrelates, or a constant ΔP, or both.
struct InflationRule {
  Inflation inflation = Inflation::none;
  InflationSolution solution = InflationSolution::pairwise;
  Matrix constant;  ///< n×n added at every step; empty for none

  /// Inflation within the update and not before it.
  bool is_sequential() const { return inflation != Inflation::none && map_bound().has_value(); }

  std::optional<internal::MapBound> map_bound() const { return credence::internal::map_bound(solution); }
};

}  // namespace credence
