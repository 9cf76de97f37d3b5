#pragma once

#include "analysis/evidence/consistency.h"

namespace credence::internal {

/// The verdict on NIS that had to pass a gate, all of dimension `dof`: each step and the sum, as judge_nis,
/// with the law of χ²(dof) truncated at `gate` (chi_square_truncated.h).
///
/// The sums are taken as matched in three cumulants: an approximation, good from about 20 values a step on
/// for the 99 % gate. count values of a step, all ≤ gate; NEES of a gated filter has no such simple law.
/// Throws as judge_nis, and unless dof and gate are > 0.
ConsistencyVerdict judge_gated_nis(std::span<const Moments> per_step, double dof, double gate,
                                   double confidence);

}  // namespace credence::internal
