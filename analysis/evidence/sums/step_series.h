#pragma once

#include <cstdint>
#include <utility>
#include <vector>

/// @file
/// Sums for each step: entry k − 1 is step k, and series of different lengths add up to the longer one.
///
/// A run may have any number of steps, and what is kept of each of them takes some hundred bytes: beyond
/// kMostSteps only every s-th step from the first on has sums, s = 2, 4, 8, …, and entry k is step 1 + k s.

namespace credence::internal {

inline constexpr std::int64_t kMostSteps = std::int64_t{1} << 17;

/// Every second entry, from the first.
template <class Sums>
void drop_every_second(std::vector<Sums>& series) {
  for (std::size_t k = 1; 2 * k < series.size(); ++k) series[k] = std::move(series[2 * k]);
  series.resize((series.size() + 1) / 2);
}

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

}  // namespace credence::internal
