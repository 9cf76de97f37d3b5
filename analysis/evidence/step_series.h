#pragma once

#include <cstdint>
#include <vector>

/// @file
/// Sums for each step: entry k − 1 is step k, and series of different lengths add up to the longer one.

namespace credence {

/// The sums of step `step` (from 1), made if they are not there.
template <class Sums>
Sums& at_step(std::vector<Sums>& series, std::int64_t step) {
  const auto k = static_cast<std::size_t>(step) - 1;
  if (series.size() <= k) series.resize(k + 1);
  return series[k];
}

template <class Sums>
void merge_series(std::vector<Sums>& series, const std::vector<Sums>& later) {
  if (series.size() < later.size()) series.resize(later.size());
  for (std::size_t k = 0; k < later.size(); ++k) series[k].merge(later[k]);
}

}  // namespace credence
