#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// How far an error may lie where P claims certainty, relative to the other normalised errors or to 1:
/// rounding of the estimate, not evidence.
inline constexpr double kCertainError = 1e-9;

/// Finds the states that are known to the rounding of their estimate x̂: of an estimate of 10 a σ of 1e-19 is
/// none. Where the error, too, is no larger than the rounding, the filter claims certainty and has it; the
/// state is then to be judged as one of zero variance. With an estimate of another size none are found.
inline void find_certain_states(const VectorRef& estimate, const VectorRef& error, const MatrixRef& P,
                                std::vector<Index>& certain) {
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  certain.clear();
  const Index known = estimate.size() == error.size() ? error.size() : 0;
  for (Index i = 0; i < known; ++i) {
    const double rounding = kRounding * std::abs(estimate[i]), variance = P(i, i);
    if (variance > 0.0 && variance < rounding * rounding && std::abs(error[i]) <= rounding) {
      certain.push_back(i);
    }
  }
}

/// Finds the states of variance 0, and without covariances but those that are not known (NaN), that have an
/// error: of these alone P claims a certainty that is wrong, and the others can be judged without them.
inline void find_wrongly_certain_states(const VectorRef& error, const MatrixRef& P,
                                        std::vector<Index>& wrong) {
  wrong.clear();
  for (Index i = 0; i < std::min(error.size(), P.rows()); ++i) {
    if (P(i, i) != 0.0 || !(std::abs(error[i]) > kCertainError) || !std::isfinite(error[i])) continue;
    const auto alone = [](double covariance) { return !(std::abs(covariance) > 0.0); };
    if (std::ranges::all_of(P.row(i), alone) && std::ranges::all_of(P.col(i), alone)) wrong.push_back(i);
  }
}

/// What is judged where states are certain: no error, no variance, no covariances.
inline void make_certain(const std::vector<Index>& certain, Vector& error, Matrix& P) {
  for (const Index i : certain) {
    error[i] = 0.0;
    P.row(i).setZero();
    P.col(i).setZero();
  }
}

}  // namespace credence::internal
