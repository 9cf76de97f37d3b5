#include "analysis/laws/correlation/thinned_series.h"

#include <algorithm>

namespace credence::internal {

ThinnedSeries thinned(std::span<const double> values, std::size_t longest) {
  constexpr std::size_t kLongest = 20'000;
  const std::size_t group = (std::max(longest, values.size()) + kLongest - 1) / kLongest;
  if (group <= 1) return {{values.begin(), values.end()}, 1.0};
  ThinnedSeries result{{}, static_cast<double>(group)};
  for (std::size_t i = 0; i + group <= values.size(); i += group) {
    double sum = 0.0;
    for (std::size_t j = i; j < i + group; ++j) sum += values[j];
    result.values.push_back(sum / static_cast<double>(group));
  }
  return result;
}

}  // namespace credence::internal
