#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "core/types.h"

namespace credence::internal {

/// A bound in closed form for a map that is block diagonal minus a low rank, P_f = D − L Lᵀ, as one update
/// leaves it: E_j = factor_j L_j L_jᵀ, with L_j the d×m rows of landmark j (theory, sections 4 and 5).
///
/// With i the distinguished landmark, σ_j = ‖L_j‖ (Frobenius) and T = Σ_{j≠i} σ_j:
///   factor_i = t,  factor_j = 1 + excess/σ_j,  excess = (1/t − 1) T,  for any t in (0, 1].
/// What is left of the update is D_j − (1 − factor_j) L_j L_jᵀ: for t < 1 landmark i keeps a part of its
/// reduction and all others grow; for t = 1 ("drop") nothing changes: the map never improves.
struct ReductionBound {
  Index distinguished = -1;  ///< i; −1 when there is none (drop)
  double t = 1.0;
  double excess = 0.0;

  /// E_j = factor · L_j L_jᵀ, given σ_j = ‖L_j‖. For σ_j = 0 there is nothing to scale: 1.
  double factor(Index j, double sigma_j) const {
    if (j == distinguished) return t;
    return excess > 0.0 && sigma_j > 0.0 ? 1.0 + excess / sigma_j : 1.0;
  }

  /// e_j of E_j = e_j u_j u_jᵀ for a rank-one reduction, u_j = l_j/a_j, a_j = ‖l_j‖.
  double weight(Index j, double a_j) const {
    return j == distinguished ? t * a_j * a_j : a_j * (a_j + excess);
  }
};

/// The largest of some norms, and the sum of the others, which a subtraction at the end would spoil.
struct LargestNorm {
  double norm = 0.0, others = 0.0;
  Index at = -1;  ///< whose it is

  void take(Index index, double other) {
    others += std::min(norm, other);
    if (other > norm) {
      norm = other;
      at = index;
    }
  }
  bool dominates() const { return norm > others; }
};

/// What is done with the part of the measurements' information that would correlate landmarks.
enum class MapBound {
  least_trace,  ///< rank_one_bound: the inflation of least trace after each scalar, exact
  batch,        ///< batch_bound: after all of them together
  drop,         ///< drop_bound: no landmark's variance ever falls
};

/// The exact minimal-trace bound of D − l lᵀ (theory, section 4): i the largest a_j = ‖l_j‖, L = Σ_{j≠i} a_j;
/// if a_i ≤ L then e_j = a_j², else e_i = a_i L and e_j = a_j² + a_j (a_i − L). The trace kept is (a_i − L)².
///
/// l is n_f×1, in blocks of d. One pass, O(N), no allocation, and no cancellation in L. Throws
/// std::invalid_argument for d < 1 or a length that is no multiple of d.
ReductionBound rank_one_bound(const VectorRef& l, Index d);

/// The bound for L of any number of columns (n_f×m) that is valid, not exact, with i = `observed`: for the
/// given t, or without one for t = min(1, T/σ_i), where its trace is least. For m = 1 and i the largest this
/// is the exact one. Throws as rank_one_bound, and for an `observed` that does not exist or a t outside (0,
/// 1].
ReductionBound low_rank_bound(const MatrixRef& L, Index d, Index observed,
                              std::optional<double> t = std::nullopt);

/// Whether the bound of least trace lowers tr D of the map, which falls by excess², by more than rounding may
/// raise it. One that does not is to be dropped: then the stored tr D never rises (theory, section 5, Theorem
/// 3).
///
/// The entries added to D round by ε/2 tr D in all, and the share t of landmark i by ε/2 a_i² ≤ ε/2 tr D;
/// what else is rounded is relative to a_i · excess.
inline bool lowers_trace(double excess, double map_trace) {
  return excess * excess > 16.0 * std::numeric_limits<double>::epsilon() * map_trace;
}

/// The bound that drops the reduction: E_j = L_j L_jᵀ.
inline ReductionBound drop_bound() { return {}; }

/// Adds E_j to block j of `blocks` (d × n_f, the diagonal blocks side by side). O(N), symmetric to the last
/// bit.
void add_bound(const ReductionBound& bound, const MatrixRef& L, Index d, Eigen::Ref<Matrix> blocks);

/// Takes the inflated reduction from D: block j becomes D_j − L_j L_jᵀ + E_j, without the cancellation of
/// doing it in two steps. O(N), symmetric to the last bit.
void reduce_and_inflate(const ReductionBound& bound, const MatrixRef& L, Index d, Eigen::Ref<Matrix> blocks);

}  // namespace credence::internal
