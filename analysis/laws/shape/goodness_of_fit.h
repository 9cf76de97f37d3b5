#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

/// @file
/// NIS values against their fully specified law: χ²(dof), or truncated by a gate; no fitted parameter
/// (theory, section 7).
///
/// Values are first taken through their distribution function, so that dimensions may differ; under
/// consistency the results are independent and uniform on [0, 1]. Assumed: white innovations; all values of a
/// study may then be tested together.

namespace credence::internal {

/// Both tests of uniformity.
struct GoodnessOfFit {
  std::int64_t count = 0;
  double kolmogorov = 0.0;  ///< D = sup |F_n(u) − u|
  double kolmogorov_p_value = 0.0;
  double anderson = 0.0;  ///< A² = n ∫ (F_n(u) − u)² / (u (1 − u)) du: sees the tails
  double anderson_p_value = 0.0;
  std::string_view reason = {};  ///< why there is no test (p-values NaN), else empty
};

/// P(D_n > d) for n independent uniform values ([Marsaglia 2003]: exact, for n ≤ 140; beyond,
/// Kolmogorov's limit with the correction of [Vrbik 2018], error below 2e-4). Throws unless n ≥ 1.
double kolmogorov_p_value(double d, std::int64_t n);

/// P(A²_n > a) for n independent uniform values ([Marsaglia 2004], error below 2e-5 in the
/// limit; far tail: the leading terms √3 erfc(√a) (1 + 0.3/a) of its weighted χ² series, relative error below
/// 1e-3). Throws unless n ≥ 1.
double anderson_p_value(double a, std::int64_t n);

/// Tests that the values are independent and uniform on [0, 1]. No test, with a reason, without values or for
/// one that is NaN or outside [0, 1]. A value of exactly 0 or 1 makes A² infinite and its p-value 0.
GoodnessOfFit test_uniform(std::vector<double> values);

/// F(nis[i]; dof): the values that test_uniform wants.
std::vector<double> nis_to_uniform(std::span<const double> nis, double dof);

}  // namespace credence::internal
