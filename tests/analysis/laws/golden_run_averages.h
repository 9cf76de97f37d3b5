#pragma once

#include <array>

#include "montecarlo/engine/skewed_moments.h"

namespace credence::internal::test {

/// Run averages of the NEES of 24 runs of a monobot with two landmarks (n = 3, 100 steps), drawn and rounded
/// by `sharp_verdict.py golden` beside this file, which also prints the numbers that the tests expect of
/// them.
inline constexpr std::array kRunAverages{0.97,  0.965, 0.421, 1.029, 0.545, 0.819, 0.978, 0.631,
                                         0.963, 0.702, 0.983, 0.391, 0.741, 0.6,   1.123, 1.392,
                                         6.028, 0.524, 0.68,  0.523, 1.764, 1.609, 0.898, 1.031};

/// The moments of the first `count` of them.
inline SkewedMoments golden_moments(std::size_t count) {
  SkewedMoments moments;
  for (std::size_t i = 0; i < count; ++i) moments.add(kRunAverages[i]);
  return moments;
}

}  // namespace credence::internal::test
