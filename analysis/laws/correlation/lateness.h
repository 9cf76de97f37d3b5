#pragma once

#include <cstdint>
#include <string_view>

#include "analysis/laws/correlation/group_sums.h"
#include "analysis/laws/shape/vector_moments.h"
#include "core/nan.h"
#include "core/types.h"
#include "montecarlo/engine/moments.h"

/// @file
/// Whether errors point back along the way: what a filter shows that takes late measurements for new ones.
///
/// With the error e = x̂ − x, the step a of the estimate, which may be that of the mean over the last few, and
/// both whitened by the symmetric root of P (correlation_whitening.h), u and b. A filter that is d steps late
/// follows the truth of then, so that e is about −d a. Of the exact filter E[e_k | z_1 … z_k] = 0, and b_k is
/// a function of what was measured: E[bᵀu] = 0 at every step, however the errors are correlated in time.

namespace credence::internal {

/// Of all runs.
struct LatenessSums {
  VectorMoments runs{};  ///< the averages [bᵀu, bᵀb, uᵀu, u, b] of each
  /// d of each run, and of each of ten stretches of a run, by least squares with a mean of its own, so that
  /// an error that stays is none; where the motion varies.
  Moments run_slopes{}, stretch_slopes{};

  /// Joins the runs of one dimension; others are left out.
  void merge(const LatenessSums& later);
};

/// Of the run at hand.
class RunLateness {
 public:
  static constexpr Index kLargest = 24;

  /// u and b of a step; one of another dimension than the first, or that is not finite, is left out.
  void add(const VectorRef& u, const VectorRef& b);
  /// The run ended well: it joins the others.
  void add_to(LatenessSums& sums) const;

 private:
  void add_stretches(double least_varied, LatenessSums& sums) const;

  Index dim_ = 0;
  GroupSums groups_{};  ///< Σ [bᵀu, bᵀb, uᵀu, u, b]
};

/// Why there is no test of runs along one way.
inline constexpr std::string_view kNoVariedMotion = "the motion is always the same";

/// The slope of errors over the way.
struct LatenessTest {
  std::int64_t runs = 0;
  double steps = 0.0;            ///< d, by least squares; < 0: the errors point ahead
  double p_value = 0.0;          ///< of d > 0, one-sided
  double ahead_p_value = kNaN;   ///< of d < 0; NaN of fewer than ten runs
  double explained = 0.0;        ///< of the mean of uᵀu in excess of its dimension, by e = −d a
  std::string_view reason = {};  ///< why there is no test (numbers NaN), else empty
};

/// Student's t over the runs of the averages of (b − b̄)ᵀu, b̄ over all runs: less its mean, since errors along
/// a motion that is always the same may as well be a bias. Approximate for few runs, whose law is no
/// Gaussian. No test where less than a tenth of bᵀb is left.
///
/// Of three to nine runs Student's t of d of each run, of one and two that of d of their stretches
/// [Ibragimov 2010]: from few groups that are nearly independent, the t of their estimates holds 5 % and less
/// however much their variances differ. The corrections that follow an error within the run turn the estimate
/// back, so that d of an exact filter is a little below zero: on the safe side, and no test of d < 0.
LatenessTest test_lateness(const LatenessSums& sums);

}  // namespace credence::internal
