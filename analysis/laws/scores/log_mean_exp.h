#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace credence::internal {

/// ln of the mean of e^{logs}, of at least one, without overflow: the logarithm of a mixture of e-values.
inline double log_mean_exp(std::span<const double> logs) {
  const double largest = *std::max_element(logs.begin(), logs.end());
  if (std::isinf(largest)) return largest;
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum / static_cast<double>(logs.size()));
}

}  // namespace credence::internal
