#pragma once

#include <cstdint>

#include "analysis/laws/correlation/long_lags.h"

namespace credence::internal {

/// How much more sums of squares of correlated innovations vary than those of white ones.
struct SquareCorrelation {
  double of_sum = 1.0;        ///< Var Σ_k |u_k|², over that of white u
  double of_component = 1.0;  ///< Var Σ_k (aᵀu_k)², likewise, at most, in whichever direction a
  /// false: they are worth too few values to say, or part of them stays in whole runs. What is above is then
  /// what it can be at most: as if every run were one value.
  bool known = true;
};

/// The correlations in time of so many runs (≥ 1), whose |u_k|² have so many dof in all: those of the
/// products, and of values that are in none, as of the first steps.
struct TimeCorrelations {
  LongLags lags;
  std::int64_t runs = 1;
  double dof = 0.0;
};

/// Of Gaussian u_k, normalised, with R_h the correlation of u_k and u_{k−h}: 1 + 2 Σ_h ‖R_h‖_F²/m and
/// 1 + 2 Σ_h ‖R_h‖₂², as Cov(|u_k|², |u_{k−h}|²) = 2 ‖R_h‖_F², over lags to 20 and, of means of blocks,
/// beyond; what chance makes of ‖R_h‖² is taken off. 1 of what is white.
///
/// Where the values are worth fewer than twenty, each run counts as one: of one component in one run,
/// Gaussian and of any correlation, the mean of u² exceeds any value from 1.54 on no more often than χ²(1)
/// does [Székely 2003]; of more it is taken to be so. So, in part, where R_h is clearly positive at the lags
/// of the last half: that share c of the variance is taken to stay in whole runs, c as large as it may be
/// where χ²(runs m) shows the lowest tenth of its values. Approximate, as N/τ is taken as ten less than it
/// looks (measured levels: docs/statistics.md).
SquareCorrelation square_correlation(const TimeCorrelations& of);

/// The same of one number each that is as good as its NIS, of which NIS is a function that grows: Var Σ over
/// that of white ones is 1 + 2 Σ_h r_h.
SquareCorrelation score_correlation(const TimeCorrelations& of);

}  // namespace credence::internal
