#pragma once

#include "analysis/stability/ranks.h"
#include "reports/render/json_numbers.h"

/// @file
/// What the documents of `credence stability` of linear and of planar worlds have in common.

namespace credence::internal {

/// A rank with its gap and the singular values that it rests on.
Json rank_json(const RankDecision& decision);

/// Eigenvalues as pairs [re, im].
Json eigenvalues_json(const Eigen::VectorXcd& values);

}  // namespace credence::internal
