#pragma once

#include "core/inflation.h"
#include "core/types.h"

namespace credence {

/// The covariance inflation of a filter: a rule that decorrelates, or a constant ΔP, or both.
struct InflationRule {
  Inflation inflation = Inflation::none;
  InflationSolution solution = InflationSolution::pairwise;
  Matrix constant;  ///< n×n added at every step; empty for none

  /// Inflation within the update and not before it.
  bool is_sequential() const {
    return inflation != Inflation::none && solution == InflationSolution::sequential;
  }
};

}  // namespace credence
