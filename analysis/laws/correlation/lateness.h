#pragma once

#include <cstdint>
#include <string_view>

#include "analysis/laws/shape/consistency_vector_moments.h"
#include "core/types.h"

/// @file
/// Whether errors point back along the way: what a filter shows that takes late measurements for new ones.
///
/// With the error e = x̂ − x, the step a of the estimate, which may be that of the mean over the last few, and
/// both whitened by the symmetric root of P (correlation_whitening.h), u and b. A filter that is d steps late
/// follows the truth of then, so that e is about −d a. Of the exact filter E[e_k | z_1 … z_k] = 0, and b_k is
/// a function of what was measured: E[bᵀu] = 0 at every step, however the errors are correlated in time.

namespace credence::internal {

/// Of the run at hand.
class RunLateness {
 public:
  static constexpr Index kLargest = 24;

  /// u and b of a step; one of another dimension than the first, or that is not finite, is left out.
  void add(const Vector& u, const Vector& b);
  /// The run ended well: its averages [bᵀu, bᵀb, uᵀu, u, b] join those of the others.
  void add_to(VectorMoments& runs) const;

 private:
  std::int64_t steps_ = 0;
  double across_ = 0.0, motion_ = 0.0, error_ = 0.0;  ///< Σ bᵀu, Σ bᵀb, Σ uᵀu
  Vector u_{}, b_{};                                  ///< their sums
};

/// Joins the runs of one dimension; others are left out.
void merge_lateness(const VectorMoments& later, VectorMoments& runs);

/// Why there is no test of runs along one way.
inline constexpr std::string_view kNoVariedMotion = "the motion is always the same";

/// The slope of errors over the way.
struct LatenessTest {
  std::int64_t runs = 0;
  double steps = 0.0;            ///< d, by least squares; < 0: the errors point ahead
  double p_value = 0.0;          ///< of d > 0, one-sided
  double explained = 0.0;        ///< of the mean of uᵀu in excess of its dimension, by e = −d a
  std::string_view reason = {};  ///< why there is no test (numbers NaN), else empty
};

/// Student's t over the runs of the averages of (b − b̄)ᵀu, b̄ over all runs: less its mean, since errors along
/// a motion that is always the same may as well be a bias. Approximate for few runs, whose law is no
/// Gaussian. No test with fewer than ten runs, or where less than a tenth of bᵀb is left.
LatenessTest test_lateness(const VectorMoments& runs);

}  // namespace credence::internal
