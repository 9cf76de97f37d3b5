#pragma once

#include <cstdint>
#include <string_view>

#include "analysis/laws/shape/vector_moments.h"

namespace credence::internal {

/// Whether the components of a whitened error are uncorrelated.
struct ErrorCorrelationTest {
  std::int64_t runs = 0;
  double largest = 0.0;  ///< largest |correlation| between two components
  double dof = 0.0;      ///< n (n − 1) / 2
  double p_value = 0.0;
  std::string_view reason = {};  ///< why there is no test (numbers NaN), else empty
};

/// Bartlett's test [Bartlett 1954] that u = R^{-1/2} D⁻¹ e, P = D R D, of one step has uncorrelated
/// components over the runs, by det R, R the sample correlation of u. The p-value is that of ln det R, its
/// law matched in its three exact cumulants, as χ²(n (n − 1) / 2) of ln det R with Bartlett's factor rejects
/// three times too often of 15 states and 20 runs. A factor on P or on a variance of a diagonal P leaves R at
/// I; a cross-covariance that is missing or wrong does not. Needs M > n + 1 runs, independent ones: a single
/// step, as errors are correlated in time.
ErrorCorrelationTest test_error_correlation(const VectorMoments& whitened);

}  // namespace credence::internal
