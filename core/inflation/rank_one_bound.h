#pragma once

#include <algorithm>
#include <limits>

#include "core/types.h"

namespace credence::internal {

/// The inflation of least trace, in closed form, of a map that is block diagonal minus rank one, D − l lᵀ, as
/// one scalar update leaves it: E_j = factor_j l_j l_jᵀ, with l_j the d rows of landmark j (theory, section
/// 4).
///
/// With i the distinguished landmark, a_j = ‖l_j‖ and L = Σ_{j≠i} a_j: factor_i = t = L/a_i and
/// factor_j = 1 + excess/a_j, excess = a_i − L. What is left of the update is D_j − (1 − factor_j) l_j l_jᵀ:
/// landmark i keeps a part of its reduction and all others grow; without one nothing changes.
struct ReductionBound {
  Index distinguished = -1;  ///< i; −1 when there is none
  double t = 1.0;
  double excess = 0.0;
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
  drop,         ///< none: no landmark's variance ever falls
};

/// The exact minimal-trace bound of D − l lᵀ (theory, section 4): i the largest a_j = ‖l_j‖, L = Σ_{j≠i} a_j;
/// if a_i ≤ L then e_j = a_j², else e_i = a_i L and e_j = a_j² + a_j (a_i − L). The trace kept is (a_i − L)².
///
/// l is n_f×1, in blocks of d. One pass, O(N), no allocation, and no cancellation in L. Throws
/// std::invalid_argument for d < 1 or a length that is no multiple of d.
ReductionBound rank_one_bound(const VectorRef& l, Index d);

/// Whether the bound of least trace lowers tr D of the map, which falls by excess², by more than rounding may
/// raise it. One that does not is to be dropped: then the stored tr D never rises (theory, section 5, Theorem
/// 3).
///
/// The entries added to D round by ε/2 tr D in all, and the share t of landmark i by ε/2 a_i² ≤ ε/2 tr D;
/// what else is rounded is relative to a_i · excess.
inline bool lowers_trace(double excess, double map_trace) {
  return excess * excess > 16.0 * std::numeric_limits<double>::epsilon() * map_trace;
}

/// Takes the inflated reduction from D, the diagonal blocks side by side (d × n_f): block j becomes
/// D_j − l_j l_jᵀ + E_j, without the cancellation of doing it in two steps. O(N), symmetric to the last bit.
/// Throws std::invalid_argument for sizes that do not match.
void reduce_and_inflate(const ReductionBound& bound, const VectorRef& l, Index d, Eigen::Ref<Matrix> blocks);

}  // namespace credence::internal
