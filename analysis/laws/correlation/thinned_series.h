#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace credence::internal {

/// A series, or of a long one averages of so many successive values that at most 20,000 are left: its
/// correlation time costs the square of its length.
struct ThinnedSeries {
  std::vector<double> values;
  double rows_per_value = 1.0;
};

/// longest: of the series that are looked at together, so that all are thinned alike; 0: this one.
ThinnedSeries thinned(std::span<const double> values, std::size_t longest = 0);

}  // namespace credence::internal
