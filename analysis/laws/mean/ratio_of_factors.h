#pragma once

#include "analysis/laws/mean/student.h"

namespace credence::internal {

/// A factor with its interval, whose ends are so many standard deviations of a Gaussian away.
struct FactorInterval {
  double factor = 0.0, lower = 0.0, upper = 0.0, quantile = 0.0;

  /// Whether it is above 0, and its interval too, and finite.
  bool is_known() const;
};

/// How one factor differs from another.
struct RatioOfFactors {
  MeanInterval ratio{};  ///< of the second to the first, at the confidence asked for
  double p_value = 1.0;  ///< that it is 1
};

/// The p-value that the geometric mean of two factors is 1, by their intervals alone, as of independent ones.
double p_value_of_middle(const FactorInterval& second, const FactorInterval& first);

/// The ratio from both intervals alone, in logarithms [Zou 2008]: as of independent factors, wider than it
/// need be where both met the same noise. Of two that are equal, with intervals of no width, the p-value
/// is 1.
RatioOfFactors ratio_of_factors(const FactorInterval& second, const FactorInterval& first, double confidence);

}  // namespace credence::internal
