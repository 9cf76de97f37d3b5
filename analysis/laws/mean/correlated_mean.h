#pragma once

#include "analysis/laws/correlation/whiteness.h"
#include "analysis/laws/mean/zero_mean.h"

namespace credence::internal {

/// Tests the mean of the normalised innovations of a few runs for zero, be they white or not.
///
/// values: all of them; products: the same by their lags. Where they are white about their mean, by
/// test_whiteness at `confidence`, test_zero_mean. Else N ūᵀ Ω⁻¹ ū, with the covariance that the average has
/// over time, Ω = C_0 + Σ_h w_h (C_h + C_hᵀ), C_h about the mean, w_h = min(1, 2 − 2 h/(H + 1)), by
/// Hotelling's law of 0.75 N/(H + 1) values, which is how well Ω is known. No test, with a reason, of fewer
/// than its components need, and where the correlation lasts beyond the lags.
///
/// Approximate: of autoregressions of two components (φ = 0 to 0.8, 100 to 2000 values, 1000 studies each) it
/// rejects 4 to 10 % at 5 %, of 50 values up to 14 %, where test_zero_mean rejects 19 to 75 % from φ = 0.3
/// on.
ZeroMeanTest test_correlated_mean(const VectorMoments& values, const LagProducts& products,
                                  double confidence);

}  // namespace credence::internal
