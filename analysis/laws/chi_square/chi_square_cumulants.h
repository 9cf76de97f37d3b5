#pragma once

#include "analysis/laws/chi_square/chi_square.h"

/// @file
/// Sums that are nearly but not exactly χ²: a χ² law shifted and scaled to the same first three cumulants.
///
/// X ≈ mean ± √(variance / 2ν) (χ²(ν) − ν) with ν = 8 variance³ / third² (Pearson's type III; for weighted
/// sums of χ² this is the method of Hall, Buckley and Eagleson). Exact for a multiple of χ²; approximate
/// else, with an error that falls as the number of terms grows: for few unequal terms its lower tail is cut
/// off too early, as its support is.

namespace credence::internal {

/// The first cumulants of a sum; those of independent parts add up.
struct Cumulants {
  double mean = 0.0;
  double variance = 0.0;
  double third = 0.0;

  Cumulants operator+(const Cumulants& other) const {
    return {mean + other.mean, variance + other.variance, third + other.third};
  }
  /// The cumulants of `factor` independent copies.
  Cumulants operator*(double factor) const { return {factor * mean, factor * variance, factor * third}; }
};

/// min(1, 2 min(P(X ≤ x), P(X ≥ x))); NaN for a NaN x. Throws std::invalid_argument unless the cumulants are
/// finite and the variance positive.
double two_sided_p_value(double x, const Cumulants& cumulants);

/// P(X ≥ x). Throws as two_sided_p_value.
double upper_p_value(double x, const Cumulants& cumulants);

/// The equal-tailed interval that holds X with this probability. Throws as two_sided_p_value, and unless
/// 0 < confidence < 1.
ChiSquareBounds sum_bounds(const Cumulants& cumulants, double confidence);

}  // namespace credence::internal
