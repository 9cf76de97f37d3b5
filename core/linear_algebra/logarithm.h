#pragma once

#include "core/types.h"

namespace credence::internal {

/// ln x with the same bits on every machine (core/manifold/trigonometry.h tells why), within one unit in the
/// last place. −∞ at 0, not a number below.
double natural_logarithm(double x);

/// ln Π x_i of `count` numbers, each `stride` after the one before: one logarithm of a product whose exponent
/// is kept apart.
double log_of_product(const double* x, Index count, Index stride);

/// ln |L Lᵀ| of a triangular factor by its diagonal.
double log_determinant_of_factor(const MatrixRef& L);

}  // namespace credence::internal
