#pragma once

#include "analysis/laws/correlation/whiteness.h"

namespace credence::internal {

/// How much more sums of squares of correlated innovations vary than those of white ones.
struct SquareCorrelation {
  double of_sum = 1.0;        ///< Var Σ_k |u_k|², over that of white u
  double of_component = 1.0;  ///< Var Σ_k (aᵀu_k)², likewise, at most, in whichever direction a
  bool known = true;          ///< false: they are correlated over more steps than are looked at
};

/// Of Gaussian u_k, normalised, of which `products` are about their mean, with R_h the correlation of u_k and
/// u_{k−h}: 1 + 2 Σ_h ‖R_h‖_F²/m and 1 + 2 Σ_h ‖R_h‖₂², as Cov(|u_k|², |u_{k−h}|²) = 2 ‖R_h‖_F².
///
/// What chance makes of ‖R_h‖² is taken off. The sums end at the window of [Sokal 1989]; where that is beyond
/// the lags, the rest is that of a geometric series from the lags of the second quarter to those of the last,
/// at most half of what is within: else, and where the N values are worth fewer than fifty, not known. 1 of
/// what is white. Approximate: N/τ is taken as ten less than it looks, and then Σ|u|² as τ' χ²(N m/τ') has
/// each tail of 2.5 % at 0.5 to 5 % of autoregressions (φ 0.3 to 0.95, 100 to 4000 values, one run or thirty,
/// one or three components).
SquareCorrelation square_correlation(const LagProducts& products);

/// The same of one number each that is as good as its NIS, of which NIS is a function that grows: Var Σ over
/// that of white ones is 1 + 2 Σ_h r_h.
SquareCorrelation score_correlation(const LagProducts& products);

}  // namespace credence::internal
