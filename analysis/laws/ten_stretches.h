#pragma once

#include <cstddef>
#include <span>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

/// As many equal stretches is a run cut into whose average is tested (test_single_run).
inline constexpr std::size_t kTestedStretches = 10;

/// Stretches are at least so many correlation times long, so that neighbours are nearly independent.
inline constexpr double kShortestStretch = 10.0;

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
