#pragma once

#include "analysis/laws/shape/vector_moments.h"

/// @file
/// Whether innovations of two sensors are correlated in a way that no noise makes that is wrong in one
/// direction.
///
/// A linear filter that takes them in turn has the normalised innovations J w of independent errors w: that
/// of the prior, and the measurement noises. Where none of these is smaller than claimed, or none larger, as
/// Q, R and P0 that are wrong in one direction make them, the covariance of all innovations together is I +
/// E, E = J (cov w − claimed) Jᵀ positive, or negative, semidefinite. The squares of a fixed combination aᵀu
/// of length 1 then add up to no less, or no more, than χ²: a combination that has no excess itself is
/// correlated with nothing.

namespace credence::internal {

/// The p-value of that, from the mean squares of (u_i ± u_j)/√2, i of the first p components and j of the
/// others: one of these below and another above χ², Bonferroni over all of them. 1 without values. Proved for
/// Gaussian errors. Throws std::invalid_argument unless 0 < p < the dimension of u.
double opposed_moments_p_value(const VectorMoments& values, Index first);

}  // namespace credence::internal
