#pragma once

#include <cstdint>
#include <string>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {

/// P where it claims a small σ and where it claims a large one, of the states whose σ varies: one that is too
/// small in some rows and too large in others may be right on average (calibration.h).
struct ClaimedSigmaTest {
  struct Side {
    std::string in;         ///< the range where it shows most: "vx where its σ is 0.1 to 0.178"
    double p_value = kNaN;  ///< two-sided, Bonferroni over the ranges; NaN: not tested
    MeanInterval factor;    ///< between true and claimed variance
  };
  Side optimistic, pessimistic;
  std::int64_t units = 0;  ///< runs, or stretches of fewer than five, of the range with most of them
};

}  // namespace credence::internal
