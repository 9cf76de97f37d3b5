#pragma once

#include "analysis/stability/riccati_doubling.h"

/// @file
/// Units that a Riccati problem is best solved in.

namespace credence::internal {

/// The same problem in states x' = D⁻¹ x, D = diag(d), and measurements whitened to R = I.
///
/// The d are powers of two, so nothing is rounded but the whitening; they balance the rows of F and Q_t
/// against the columns of F and Hᵀ R⁻¹ H, the two halves of the symplectic pencil.
struct ScaledRiccati {
  RiccatiProblem problem;
  Matrix P0;
  Vector d;

  /// A covariance of the scaled states in the caller's units.
  Matrix unscaled(const Matrix& P) const { return d.asDiagonal() * P * d.asDiagonal(); }
};

/// Scales a valid problem.
ScaledRiccati scale_riccati(const RiccatiProblem& problem, MatrixRef P0);

}  // namespace credence::internal
