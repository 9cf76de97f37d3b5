#pragma once

#include <span>
#include <vector>

#include "core/types.h"

/// @file
/// What is new in each error: errors that remember are sums over many steps, and sums of heavy-tailed noise
/// look Gaussian (central limit theorem), while what is added at each step keeps its law.

namespace credence::internal {

/// |r_k|²/n of the residuals r_k = z_k − A z_{k−1} of the errors z of each run, n components, one a column,
/// with A of least squares (an autoregression of first order, as the error of a linear filter at rest is
/// one), whitened by their own mean square: of Gaussian z, whatever their memory, r is Gaussian.
///
/// Of a memory that comes and goes, as of a filter with a fix in some rows and none in most, r is a mixture
/// of scales whatever the law. Then there are none: where ln σ² (`log_variances`, the mean over the states,
/// of each row) changes from row to row behind the first tenth by a root mean square of more than 0.15 of the
/// share of z that is new; where the size of the residuals of a run, or of their part in one of the
/// directions that are whitened, goes up and down in time (modulation.h) or lies for more than half in the
/// first tenth; or where the tenth of all that are largest points back, as z is forgotten in these rows more
/// than in others (Σ r·z over its root mean square, of signs that are new as N(0, 1), below −1.64, in
/// coordinates in which z is white). None, either, where a run has fewer than 136 rows or 20 n, or residuals
/// that span fewer than n dimensions. Cost N n².
std::vector<std::vector<double>> residual_nees(std::span<const Matrix> runs,
                                               std::span<const Vector> log_variances);

}  // namespace credence::internal
