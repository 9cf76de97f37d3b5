#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

/// As many equal stretches is a run cut into whose average is tested (test_single_run).
inline constexpr std::size_t kTestedStretches = 10;

/// Stretches are at least so many correlation times long, so that neighbours are nearly independent.
inline constexpr double kShortestStretch = 10.0;

/// That length in rows. By what the errors tell of the memory of NEES (memory_of_squares) seven of these
/// correlation times, neighbours of which are correlated by at most 1/28 where it is that of an
/// autoregression, and five of those that NEES itself tells, which are short where it is small by chance. Ten
/// of these where the errors are not known, NaN.
inline double shortest_stretch(double correlation_time, double memory) {
  constexpr double kByErrors = 7.0, kByNees = 5.0;
  return std::isnan(memory) ? kShortestStretch * correlation_time
                            : std::max(kByErrors * memory, kByNees * correlation_time);
}

/// The averages of a run over them; what is left over at its end is left out.
inline Moments tested_averages(std::span<const double> run) {
  const std::size_t length = run.size() / kTestedStretches;
  Moments averages;
  for (std::size_t i = 0; i < kTestedStretches; ++i) {
    double sum = 0.0;
    for (const double x : run.subspan(i * length, length)) sum += x;
    averages.add(sum / static_cast<double>(length));
  }
  return averages;
}

}  // namespace credence::internal
