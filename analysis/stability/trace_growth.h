#pragma once

#include <string_view>
#include <vector>

#include "core/nan.h"

/// @file
/// Does a covariance that is followed step by step, or loop by loop, level off?

namespace credence {

/// What tr P did over a long horizon.
enum class LongRun { bounded, growing, failed };

/// "bounded", "growing", "failed".
std::string_view to_string(LongRun verdict);

/// How a trace grew over the last half of what was followed.
struct TraceGrowth {
  LongRun verdict = LongRun::failed;
  double per_sample =
      internal::kNaN;  ///< increase from one value to the next, on average; NaN of fewer than four
  double exponent = internal::kNaN;  ///< log2(last / middle): 0 bounded, 1 linear
};

/// Judges at least four values at equal distances in time.
///
/// Growing: an exponent above ½; or the last half adds more than the share `resolution` of the trace, and no
/// less than ¾ of what the quarter before it added. Increments of a covariance that approaches a limit at
/// least halve when the time doubles; those of a logarithm stay equal, and those of a line double.
TraceGrowth judge_growth(const std::vector<double>& trace, double resolution);

}  // namespace credence
