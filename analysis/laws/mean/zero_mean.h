#pragma once

#include <cstdint>
#include <string_view>

#include "analysis/laws/shape/vector_moments.h"
#include "core/types.h"

namespace credence::internal {

/// The test that normalised vectors, innovations or errors, have mean zero.
struct ZeroMeanTest {
  std::int64_t count = 0;
  Vector mean{};          ///< in standard deviations
  double t_square = 0.0;  ///< Hotelling's N ūᵀ Ĉ⁻¹ ū ~ (N−1) m / (N−m) F(m, N−m): S may be wrong
  double p_value = 0.0;   ///< of t_square; exact for Gaussian white u
  std::string_view reason = {};  ///< why there is no test (p_value NaN), else empty
};

/// Tests the mean of the normalised innovations u = L⁻¹ ν, S = L Lᵀ, for zero: a bias of the sensor or of the
/// model. Assumed: Gaussian and white; where whiteness fails, as in errors, add the mean of each run instead
/// of each value.
///
/// Where the covariance of the values is singular, p_value is that of Student's t of each of the components,
/// Bonferroni over them, and t_square NaN; of ten values or more 0 where one is always the same and not zero.
/// Of several components and fewer than ten values, or than twice as many as there are components, where F
/// has little power (one component's mean has to be 1.6 times as large as for these t of 14 values of nine
/// components, and 12 times of ten), half the level is that of these t, and half that of the t of wᵀu, w the
/// eigenvector of Σ u uᵀ, not centred, with the largest eigenvalue: as w depends on that sum alone, it is
/// Student's for Gaussian u of mean zero, exactly, however many components there are [Läuter 1998].
ZeroMeanTest test_zero_mean(const VectorMoments& moments);

}  // namespace credence::internal
