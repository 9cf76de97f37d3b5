#pragma once

#include "analysis/tuning/score_model.h"

namespace credence::internal {

/// φ of the filter whose covariances have the factors, each within `reach` and its inverse of those at
/// `start`, that score highest: where a search of all their elements begins, which from far away ends where
/// one of two covariances has gone to 0. `start` where φ has no covariance of several elements, where its
/// scores are none, and where no factors score higher.
Vector best_scales(const ScoreModel& model, const Vector& start, double reach);

}  // namespace credence::internal
